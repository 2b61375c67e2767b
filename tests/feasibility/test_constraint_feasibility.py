"""Feasibility of rows, against closed forms and the filter's own decisions."""

from math import sqrt

import casadi as ca
import numpy as np
import pytest
from closed_form_designs import GAIN, TIGHTENING, mass, paper
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.tools.feasibility.constraint_feasibility import AT_ONCE, ConstraintFeasibility, Findings
from passafe_services.tools.feasibility.errors import FeasibilityError
from passafe_services.tools.feasibility.share import random_states

from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.system import System
from passafe.tank import Tank

FURTHEST = 20.0
"""Bounds beyond twice the longest way between two inputs are drawn in, which changes no verdict."""

DIAGONAL = (1 / sqrt(2), 1 / sqrt(2))


def box(n: int, count: int = 300, seed: int = 1, size: float = 3.0) -> np.ndarray:
    return random_states([-size] * n, [size] * n, count, seed)


@pytest.mark.parametrize(("between_samples", "tightening"), [(False, 0.0), (True, TIGHTENING)])
def test_one_wall_is_kept_where_the_brakes_are_strong_enough(between_samples: bool, tightening: float) -> None:
    """p̈ = u ≥ −2γv − γ²p can be had iff that is no more than the limit; the margin is what is left of the limit.

    A push away from the wall bends ψ₁ upwards, so that ε = 0 there.
    """
    p, v = states = box(2)
    found = ConstraintFeasibility(mass(((1.0,), 0.0), between_samples=between_samples)).at(states)
    needed = -2 * GAIN * v - GAIN**2 * p

    assert found.hard_margin == pytest.approx(5.0 - np.clip(needed + tightening, -FURTHEST, FURTHEST), abs=1e-9)
    assert np.array_equal(found.hard_kept, needed + tightening <= 5.0 + found.tolerance)
    assert 0.05 < found.hard_kept.mean() < 0.95
    assert found.protecting == pytest.approx(np.minimum(p, v + GAIN * p))
    assert found.h == pytest.approx(p)
    assert np.array_equal(found.inside, (p >= 0) & (v + GAIN * p >= 0))
    assert not found.unsettled.any()


@pytest.mark.parametrize("width", [1.5, -0.5])
def test_a_channel_of_two_walls_leaves_an_interval(width: float) -> None:
    """Rows −2γv − γ²p ≤ u ≤ −2γv + γ²(w − p): the interval has length γ²w, whatever the state; none if w < 0."""
    p, v = states = box(2)
    found = ConstraintFeasibility(mass(((1.0,), 0.0), ((-1.0,), -width))).at(states)
    low, high = -2 * GAIN * v - GAIN**2 * p, -2 * GAIN * v + GAIN**2 * (width - p)
    low, high = np.clip(low, -FURTHEST, FURTHEST), np.clip(high, -FURTHEST, FURTHEST)
    best = np.clip((low + high) / 2, -5.0, 5.0)

    assert found.hard_margin == pytest.approx(np.minimum(best - low, high - best), abs=1e-9)
    assert np.array_equal(found.hard_kept, np.maximum(low, -5.0) <= np.minimum(high, 5.0))
    assert found.hard_kept.any() == (width > 0)


@pytest.mark.parametrize(("norm", "strongest"), [(None, 5.0 * sqrt(2)), (6.0, 6.0), (4.0, 4.0), (20.0, 5 * sqrt(2))])
def test_a_limit_of_the_norm_binds_between_the_axes(norm: float | None, strongest: float) -> None:
    states = box(4)
    found = ConstraintFeasibility(mass((DIAGONAL, 0.0), input_norm_bound=norm)).at(states)
    along, speed = np.array(DIAGONAL) @ states[:2], np.array(DIAGONAL) @ states[2:]
    needed = -2 * GAIN * speed - GAIN**2 * along

    assert found.hard_margin == pytest.approx(strongest - needed, abs=1e-5)


def test_limits_of_the_rate_are_left_out() -> None:
    states = box(2, 50)
    slow, free = (
        ConstraintFeasibility(mass(((1.0,), 0.0), input_rate_bound_per_s=rate)).at(states) for rate in (1e-3, None)
    )

    assert np.array_equal(slow.hard_margin, free.hard_margin)


@pytest.mark.parametrize("tank", [None, Tank(initial_j=1.0, reserve_j=0.5, rate_per_s=5.0)])
@pytest.mark.parametrize("gain", [1.0, 10.0])
def test_away_from_the_disk_safety_and_passivity_pull_apart(gain: float, tank: Tank | None) -> None:
    """With x₁ = c·x₂, c > 0, the two gradients are antiparallel, and the interval that they leave is known.

    Along e = x₂/‖x₂‖: 2‖x₁‖eᵀu ≥ −c₁ with c₁ = 2‖x₂‖² − 2σx₁ᵀx₂ + 4γx₁ᵀx₂ + γ²(‖x₁‖² − 1), and ‖x₂‖eᵀu ≤ c₂ with
    c₂ = 2σ‖x₂‖² − 2x₁ᵀx₂ + κ(E − E_r).
    """
    c = np.linspace(0.8, 3.0, 45)
    velocity = np.array([-1.0, -1.0])
    states = np.vstack((velocity[:, None] * c, np.repeat(velocity[:, None], len(c), axis=1)))
    found = ConstraintFeasibility(paper(gain=gain, tank=tank)).at(states)
    x_1, x_2 = c * sqrt(2), sqrt(2)
    c_1 = 2 * x_2**2 + (4 * gain - 2) * x_1 * x_2 + gain**2 * (x_1**2 - 1)
    c_2 = 2 * x_2**2 - 2 * x_1 * x_2 + (0.0 if tank is None else 5.0 * 0.5)
    interval = c_2 / x_2 + c_1 / (2 * x_1)

    # With a long interval the better input is a corner of the box, not its middle.
    narrow = interval < 20.0
    assert found.passive_margin[narrow] == pytest.approx(interval[narrow] / 2, abs=1e-7)
    assert np.array_equal(found.passive_kept, interval >= 0)
    assert found.hard_kept.all()
    if gain == 1.0 and tank is None:
        assert np.array_equal(found.passive_kept, c <= 1 + sqrt(1.5))
    if gain == 10.0:
        assert found.passive_kept.all()


def test_slow_retreat_from_the_disk_conflicts_at_high_gains() -> None:
    """On the boundary, x₁ = x₂/‖x₂‖, γ = 10: 42‖x₂‖ + 2‖x₂‖² ≥ 4, by the rows of the test above."""
    speed = np.linspace(0.01, 0.3, 60)
    direction = np.array([[0.6], [-0.8]])
    states = np.vstack((np.repeat(direction, len(speed), axis=1), direction * speed))
    found = ConstraintFeasibility(paper(gain=10.0)).at(states)

    assert np.array_equal(found.passive_kept, 42 * speed + 2 * speed**2 >= 4)
    assert found.hard_kept.all()


def test_passivity_is_inactive_at_rest() -> None:
    states = box(4, 50)
    states[2:] = 0.0
    found = ConstraintFeasibility(paper(gain=10.0)).at(states)

    assert found.passive_kept.all()
    assert found.passive_margin == pytest.approx(np.zeros(50), abs=1e-9)


def test_without_barriers_everything_is_kept_and_inside() -> None:
    found = ConstraintFeasibility(mass()).at(box(2, 20))

    assert found.inside.all()
    assert found.hard_kept.all()
    assert np.isposinf(found.hard_margin).all()
    assert np.isposinf(found.h).all()


@pytest.mark.parametrize("mode", [Mode.OFF, Mode.SAFE])
def test_safety_and_passivity_rows_exist_in_every_mode(mode: Mode) -> None:
    states = box(4, 50)
    some, both = (ConstraintFeasibility(paper(gain=1.0, mode=each)).at(states) for each in (mode, Mode.BOTH))

    assert np.array_equal(some.passive_margin, both.passive_margin)
    assert np.array_equal(some.hard_margin, both.hard_margin)


def test_nan_rows_are_infeasible_without_affecting_other_states() -> None:
    good = box(2, 3)
    states = good.copy()
    states[0, 1] = np.nan
    keeping = ConstraintFeasibility(mass(((1.0,), 0.0)))
    found, alone = keeping.at(states), keeping.at(good)

    assert found.hard_kept.tolist() == [alone.hard_kept[0], False, alone.hard_kept[2]]
    assert np.isneginf(found.hard_margin[1])
    assert not found.inside[1]
    assert found.hard_margin[[0, 2]] == pytest.approx(alone.hard_margin[[0, 2]])


def test_the_continuous_law_is_refused() -> None:
    with pytest.raises(FeasibilityError, match="got continuous, allowed sampled"):
        ConstraintFeasibility(paper(gain=1.0, law=Law.CONTINUOUS))


def test_pieces_joined_are_the_whole() -> None:
    states = box(2, AT_ONCE + 17)
    keeping = ConstraintFeasibility(mass(((1.0,), 0.0)))
    parts = list(keeping.piecewise(states))

    assert [part.h.size for part in parts] == [AT_ONCE, 17]
    assert Findings.joined(parts).hard_margin == pytest.approx(keeping.at(states).hard_margin)
    assert np.array_equal(Findings.joined(parts).states, states)


def tightened(name: str) -> dict[str, object]:
    """Limits under which some states of the box are hopeless."""
    return {"filter.input_bound": 25.0, "filter.input_norm_bound": 28.0} if name != "tight-limits" else {}


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if not name.startswith(("arm-", "wrong-"))])
def test_the_filter_s_own_verdicts_agree(name: str) -> None:
    """INFEASIBLE where no input was found, and certified where one was; passivity kept by it nowhere else."""
    scenario = load_scenario(name, tightened(name) | {"filter.mode": "both"})
    design = design_of(scenario, robot_of(scenario))
    n = design.system.n
    found = ConstraintFeasibility(design).at(random_states([-3.0] * n, [3.0] * n, 250, 7))
    filtering, zero = SafetyPassivityFilter(design), (0.0,) * design.system.m
    tank = design.passivity.tank
    level_j = 0.0 if tank is None else tank.initial_j
    spendable = 0.0 if tank is None else tank.rate_per_s * (level_j - tank.reserve_j)
    compared = 0
    for x, margin, passive in zip(found.states.T, found.hard_margin, found.passive_margin, strict=True):
        decision = filtering.decide(x.tolist(), zero, zero, zero, level_j, 0.0, start=True)
        if decision.status.name == "UNCERTIFIED" or abs(margin) < 1e-4:
            continue
        compared += 1
        assert (decision.status.name == "INFEASIBLE") == (margin < 0), (x, margin)
        if passive < -1e-4 and margin > 0:
            assert decision.power_margin + spendable < 0
    assert compared >= 240


def test_rows_not_affine_in_u_are_judged_as_they_are() -> None:
    """ẋ = u³ and h = x: the row is u³ + γx ≥ 0, which u = b keeps iff b³ ≥ −γx. The tangent at u = 0 knows no way."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    design = mass(((1.0,), 0.0))
    system = System(x=x, u=u, f=u**3 + u, y=x)
    barrier = type(design.barriers[0])(name="floor", h=x, class_k=design.barriers[0].class_k[:2])
    design = FilterDesign(
        system=system,
        u_fb=ca.SX.zeros(1),
        fail_safe=ca.SX.zeros(1),
        barriers=(barrier,),
        passivity=Passivity(V=x**2),
        k_i=10.0,
        dt_s=1e-3,
        input_bound=2.0,
        between_samples=False,
    )
    states = np.linspace(-12.0, 3.0, 61)[None, :]
    found = ConstraintFeasibility(design).at(states)

    assert np.array_equal(found.hard_kept, 10.0 + GAIN * states[0] >= 0)
