"""Many plants advance as each would alone."""

import numpy as np
import pytest

from passafe.batch.batch_plant import BatchPlant
from passafe.errors import IntegrationError
from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.sampled_plant import LOCAL_TOLERANCE, SampledPlant
from passafe.storage import squared_norm

DT_S = 1e-2


def plant_of(robot: Robot, dt_s: float = DT_S) -> SampledPlant:
    return SampledPlant(robot.system, squared_norm(robot.system.x), dt_s)


def assert_each_as_alone(plant: SampledPlant, many: BatchPlant, x: np.ndarray, u: np.ndarray) -> None:
    many.advance(x, u)
    for element in range(x.shape[1]):
        sample = plant.advance(x[:, element].tolist(), u[:, element].tolist())
        got = {
            name: many.batch.part(name)[:, element].tolist() for name in ("x_next", "y", "stored", "energy", "error")
        }

        assert got["x_next"] == pytest.approx(sample.x, rel=1e-14, abs=1e-15)
        assert got["y"] == pytest.approx(sample.y, rel=1e-14, abs=1e-15)
        assert got["stored"] == pytest.approx([sample.stored_j], rel=1e-14)
        assert got["energy"] == pytest.approx([sample.energy_in_j], rel=1e-13, abs=1e-15)
        assert got["error"] == pytest.approx([sample.integration_error], rel=1e-3, abs=1e-15)


@pytest.mark.parametrize(
    "robot", [damped_point(sigma=0.7), lagged_point(sigma=1.0, lag_s=0.05), drag_point(sigma=0.5, drag=0.3)]
)
def test_plants_of_every_kind(robot: Robot) -> None:
    rng = np.random.default_rng(30)
    plant, n = plant_of(robot), robot.system.n
    many = BatchPlant(plant, 30)

    assert_each_as_alone(plant, many, rng.normal(size=(n, 30)), rng.normal(size=(2, 30)) * 5)
    x = many.batch.part("x_next")[:, :30]
    assert_each_as_alone(plant, many, x.copy(), rng.normal(size=(2, 30)))


def test_a_step_that_misses_its_accuracy_is_done_in_smaller_ones() -> None:
    """Fast plants with drag need substeps; slow ones beside them do not."""
    plant = plant_of(drag_point(sigma=0.5, drag=2.0), dt_s=5e-3)
    x = np.zeros((4, 9))
    x[2] = np.linspace(0.0, 20.0, 9)
    u = np.ones((2, 9))
    many = BatchPlant(plant, 9)
    raw = BatchPlant(plant, 9)
    raw.batch.part("x")[:, :9], raw.batch.part("u")[:, :9], raw.batch.part("h")[:] = x, u, 5e-3
    raw._step()

    missed = raw.batch.part("error")[0, :9] > LOCAL_TOLERANCE
    assert 0 < missed.sum() < 9
    assert_each_as_alone(plant, many, x, u)
    assert (many.batch.part("error")[0, :9] <= LOCAL_TOLERANCE).all()


def test_a_state_may_be_read_where_the_next_one_is_written() -> None:
    plant = plant_of(drag_point(sigma=0.5, drag=2.0), dt_s=5e-3)
    many, apart = BatchPlant(plant, 3), BatchPlant(plant, 3)
    x, u = np.full((4, 3), 6.0), np.ones((2, 3))
    many.advance(x, u)
    apart.advance(x, u)
    many.advance(many.batch.part("x_next")[:, :3], u)
    apart.advance(apart.batch.part("x_next")[:, :3].copy(), u)

    np.testing.assert_array_equal(many.batch.block, apart.batch.block)


def test_a_plant_that_cannot_be_followed_is_said() -> None:
    x = np.zeros((4, 2))
    x[2, 1] = np.nan

    with pytest.raises(IntegrationError):
        BatchPlant(plant_of(drag_point(sigma=0.5, drag=2.0)), 2).advance(x, np.zeros((2, 2)))
