from math import exp

import pytest
from passafe_services.drivers.model_driver import ModelDriver

from passafe import SampledPlant, damped_point

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)
U = (1.0, 0.0)


@pytest.fixture
def plant() -> SampledPlant:
    robot = damped_point(sigma=1.0)
    return SampledPlant(robot.system, robot.system.x.T @ robot.system.x, 1e-3)


@pytest.fixture
def driver(plant: SampledPlant) -> ModelDriver:
    return ModelDriver(plant, x0=X0, period_ns=MS)


def test_it_rests_at_x0_until_an_input_is_applied(driver: ModelDriver) -> None:
    driver.open()

    assert [driver.read(at).x for at in (0, MS, 700 * MS)] == [X0] * 3
    assert driver.read(5 * MS).at_ns == 5 * MS


def test_a_period_is_the_model_to_the_last_bit(driver: ModelDriver, plant: SampledPlant) -> None:
    driver.apply(U, 3 * MS)
    first, second = driver.read(4 * MS), driver.read(5 * MS)

    expected = plant.advance(X0, U)
    assert first.sample == expected
    assert second.sample == plant.advance(expected.x, U)
    assert second.x[2] == pytest.approx(1.0 - 2.0 * exp(-0.002), abs=1e-15)
    assert second.x[3] == pytest.approx(-exp(-0.002), abs=1e-15)


def test_equal_times_give_equal_states(driver: ModelDriver) -> None:
    driver.apply(U, 0)

    assert driver.read(MS) == driver.read(MS)
    driver.close()
    driver.close()
