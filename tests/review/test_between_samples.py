"""Extrema and the tank's ledger."""

import math

import numpy as np
import pytest
from damped_point_run import DampedPoint, header, scenario, state
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.between_samples import RecomputedMargins
from passafe_services.tools.review.energy_account import logged_gain, tank_ledger
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.trajectory import Trajectory

T = np.array([0.0, 1.0, 2.0])


def test_what_is_no_number_is_the_worst() -> None:
    values = np.array([1.0, math.nan, -5.0])
    assert Extremum.lowest(values, T) == Extremum(-math.inf, 1.0)
    assert Extremum.highest(values, T) == Extremum(math.inf, 1.0)


def test_first_of_equal_extrema_is_reported() -> None:
    assert Extremum.lowest(np.array([2.0, 1.0, 1.0]), T) == Extremum(1.0, 1.0)
    assert Extremum.highest(np.array([1.0, 2.0, 2.0]), T) == Extremum(2.0, 1.0)


def trajectory_of_energies(gained_j: list[float], stored_j: list[float]) -> Trajectory:
    return Trajectory.of(
        [
            LoggedMessage(header("plant", k), state(k, (2, 0, 0, 0), (0, 0), energy_in_j=e, energy_stored_j=v))
            for k, (e, v) in enumerate(zip(gained_j, stored_j, strict=True))
        ]
    )


energies = st.lists(st.tuples(st.floats(-100, 100), st.floats(0, 100)), min_size=1, max_size=20)


@given(energies=energies)
def test_the_ledger_is_the_sum_as_long_as_the_tank_is_not_full(energies: list[tuple[float, float]]) -> None:
    gained_j, stored_j = map(list, zip(*energies, strict=True))
    passivity = scenario().filter.passivity.model_copy(update={"tank_max_j": 1e6})
    trajectory = trajectory_of_energies(gained_j, stored_j)
    ledger = tank_ledger(logged_gain(trajectory), trajectory.session, passivity)
    expected = 1.0 + (np.array(gained_j) - gained_j[0]) - (np.array(stored_j) - stored_j[0])
    assert ledger == pytest.approx(expected, abs=1e-9)


@given(energies=energies)
def test_tank_stays_below_its_maximum_and_gains_no_extra_energy(
    energies: list[tuple[float, float]],
) -> None:
    gained_j, stored_j = map(list, zip(*energies, strict=True))
    passivity = scenario().filter.passivity
    trajectory = trajectory_of_energies(gained_j, stored_j)
    ledger = tank_ledger(logged_gain(trajectory), trajectory.session, passivity)
    assert ledger.max() <= passivity.tank_max_j
    given_j = np.diff(gained_j) - np.diff(stored_j)
    assert (np.diff(ledger) <= given_j + 1e-9).all()


def test_a_single_sample_has_margins_and_nothing_between() -> None:
    trajectory = Trajectory.of([LoggedMessage(header("plant", 0), state(3, (2, 0, 1, 0), (0, 0)))])
    margins = RecomputedMargins.of(trajectory, DampedPoint(), scenario().filter.passivity, 10)
    assert margins.h_min == margins.h_min_at_samples == Extremum(3.0, 0.003)
    assert margins.power_margin_min == Extremum(-2.0, 0.003)
    assert margins.mismatch_max is None


class TwoDisks(DampedPoint):
    """The disk, and another at (3, 0) of radius 1."""

    def h(self, x: np.ndarray, t_s: np.ndarray) -> np.ndarray:
        there = np.sum((x[:2] - np.array([[3.0], [0.0]])) ** 2, axis=0, keepdims=True) - 1
        return np.vstack([super().h(x, t_s), there])


@pytest.mark.parametrize(("to", "nearest"), [(1.2, 0), (1.8, 1)])
def test_nearest_barrier_is_reported_by_its_index(to: float, nearest: int) -> None:
    way = [LoggedMessage(header("plant", k), state(k, (1.5 + (to - 1.5) * k / 9, 0, 0, 0), (0, 0))) for k in range(10)]
    margins = RecomputedMargins.of(Trajectory.of(way), TwoDisks(), scenario().filter.passivity, 4)

    assert margins.h_min_barrier == nearest
    assert margins.h_min is not None
    assert margins.h_min.value == pytest.approx(1.2**2 - 1)
