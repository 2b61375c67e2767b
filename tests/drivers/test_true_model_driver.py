"""The robot as it really is: other parameters, disturbance and lag in closed form, equal whenever it is asked."""

from math import exp

import pytest
from passafe_services.drivers.true_model_driver import TrueModelDriver
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)


def driver_of(**truth: object) -> TrueModelDriver:
    scenario = load_scenario("notomista-cai-2020", {"plant.truth": truth})
    assert scenario.plant.truth is not None
    return TrueModelDriver.of(scenario, PlantModel.of(scenario), scenario.plant.truth)


def velocity_after(driver: TrueModelDriver, u: tuple[float, float], periods: int) -> tuple[float, ...]:
    driver.open()
    driver.read(0)
    for k in range(periods):
        driver.apply(u, k * MS)
        driver.read((k + 1) * MS)
    driver.close()
    return driver.read(periods * MS).true_x[2:]


def coasting(v: float, force: float, sigma: float, t_s: float) -> float:
    return force / sigma + (v - force / sigma) * exp(-sigma * t_s)


def test_parameters_are_those_of_the_truth() -> None:
    found = velocity_after(driver_of(parameters={"mass": 2.0, "sigma": 3.0}), (4.0, 0.0), 100)

    assert found == pytest.approx((coasting(-1, 2, 3, 0.1), coasting(-1, 0, 3, 0.1)))


def test_a_constant_disturbance_adds_to_the_rates() -> None:
    truth = {"disturbance": {"kind": "constant", "rate": {"velocity": 0.5}}}

    assert velocity_after(driver_of(**truth), (0.0, 0.0), 100) == pytest.approx((coasting(-1, 0.5, 1, 0.1),) * 2)


def test_a_lagging_actuator_is_behind_by_its_lag_on_a_ramp() -> None:
    driver = driver_of(actuator_lag_s=0.02)
    for k in range(400):
        driver.read(k * MS)
        driver.apply((10.0 * k * 1e-3, 0.0), k * MS)
    driver.read(400 * MS)

    behind = 10.0 * 399e-3 - driver._acting[0]

    assert 0.19 < behind <= 10.0 * 0.02


def test_reading_late_or_often_meets_the_same_robot() -> None:
    truth = {
        "disturbance": {"kind": "switching", "bound": {"velocity": 1.0}, "every_s": 0.01},
        "noise": {"bound": {"position": 0.001}},
        "quantisation": [0.01, 0.01, 0.0, 0.0],
    }
    often, late = driver_of(**truth), driver_of(**truth)
    for driver in (often, late):
        driver.apply((1.0, 0.0), 0)
    for k in range(50):
        often.read(k * MS)
        often.read(k * MS)

    assert often.read(50 * MS) == late.read(50 * MS)
    assert late.read(50 * MS).x != late.read(50 * MS).true_x


@pytest.mark.parametrize(
    ("truth", "field"),
    [
        ({"parameters": {"weight": 1.0}}, "plant.truth.parameters"),
        ({"noise": {"bound": [0.1]}}, "plant.truth.noise.bound"),
        ({"quantisation": [0.1]}, "plant.truth.quantisation"),
        ({"disturbance": {"kind": "greedy", "bound": [0.1]}}, "plant.truth.disturbance.bound"),
        ({"disturbance": {"kind": "sine", "bound": [0.1]}}, "plant.truth.disturbance.bound"),
        ({"disturbance": {"kind": "constant", "rate": [0.1]}}, "plant.truth.disturbance.rate"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(truth: dict[str, object], field: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        driver_of(**truth)

    assert caught.value.field == field
