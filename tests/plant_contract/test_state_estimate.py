"""The box of states that agree with all readings: it narrows, holds the truth, and shows where sets are wrong."""

import pytest
from passafe_services.filter.build import CompiledFilter
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.plant_contract.state_estimate import StateEstimate
from passafe_services.scenarios.load import load_scenario

from passafe.state_set import ErrorGrowth

SETS = {"disturbance": {"velocity": 0.5}, "state_error": {"position": 0.01, "velocity": 0.1}}
X = (2.0, 2.0, 0.0, 0.0)
U = (1.0, 0.0)


@pytest.fixture(scope="module")
def growth() -> ErrorGrowth:
    scenario = load_scenario("notomista-cai-2020", {"uncertainty": SETS, "filter.mode": "safe"})
    found = CompiledFilter.of(scenario, PlantModel.of(scenario).robot).growth
    assert found is not None
    return found


def test_the_first_box_is_that_of_the_reading(growth: ErrorGrowth) -> None:
    estimate = StateEstimate(growth)

    box = estimate.observe(X, None)

    assert (box.center, box.radius) == (X, (0.01, 0.01, 0.1, 0.1))
    assert estimate.residual == ()
    assert not estimate.is_violated


def test_readings_that_differ_narrow_the_box(growth: ErrorGrowth) -> None:
    estimate = StateEstimate(growth)
    estimate.observe(X, None)

    box = estimate.observe((2.01, 2.0, 0.1, 0.0), ())

    assert box.center == pytest.approx((2.005, 2.0, 0.05, 0.0))
    assert box.radius == pytest.approx((0.005, 0.01, 0.05, 0.1))
    assert max(estimate.residual) == pytest.approx(0.5, abs=1e-6)


def test_the_box_widens_by_the_disturbance(growth: ErrorGrowth) -> None:
    estimate = StateEstimate(growth)
    estimate.observe(X, None)
    allowed = growth.roll(estimate.newest, [U] * 100)  # type: ignore[arg-type]  # a box by then

    assert allowed.radius[2] == pytest.approx(0.1 * 0.9048374 + 0.5 * 0.0951626, rel=1e-5)


def test_a_reading_outside_is_a_violation_and_begins_anew(growth: ErrorGrowth) -> None:
    estimate = StateEstimate(growth)
    estimate.observe(X, None)
    far = (2.0, 2.0, 0.4, 0.0)

    box = estimate.observe(far, ())

    assert estimate.is_violated
    assert estimate.residual[2] == pytest.approx(2.0, abs=1e-6)
    assert (box.center, box.radius) == (far, (0.01, 0.01, 0.1, 0.1))


def test_unknown_inputs_and_a_restart_compare_nothing(growth: ErrorGrowth) -> None:
    estimate = StateEstimate(growth)
    estimate.observe(X, None)
    estimate.observe((9.0, 9.0, 9.0, 9.0), None)

    assert estimate.residual == ()
    estimate.restart()
    assert estimate.newest is None
