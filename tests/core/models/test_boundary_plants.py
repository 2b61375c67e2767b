"""Every shipped robot and storage function in the suites of ``plant_suite``."""

import casadi as ca
import numpy as np
import pytest
from finite_differences import Array
from plant_suite import PlantSuite, StorageSuite, held_inputs
from shipped_robots import ROBOTS, columns

from passafe.models.robot import Robot
from passafe.passivity import power_margin
from passafe.storage import kinetic_energy, spring_energy, squared_norm


class TestDampedPoint(PlantSuite):
    name = "damped point"


class TestDragPoint(PlantSuite):
    name = "drag point"


class TestLaggedPoint(PlantSuite):
    name = "lagged point"


class TestSaturatingPoint(PlantSuite):
    name = "saturating point"


class TestTwoPoints(PlantSuite):
    name = "two points"


class TestJointChain(PlantSuite):
    name = "joint chain"


class TestSquaredNorm(StorageSuite):
    def storage(self, robot: Robot) -> ca.SX:
        return squared_norm(robot.system.x)

    def energy(self, x: Array, coordinates: int) -> float:
        return float(x @ x)


class TestKineticEnergy(StorageSuite):
    def storage(self, robot: Robot) -> ca.SX:
        return kinetic_energy(robot.velocity)

    def energy(self, x: Array, coordinates: int) -> float:
        return float(sum(v * v / 2 for v in x[coordinates : 2 * coordinates]))


class TestSpringEnergy(StorageSuite):
    def storage(self, robot: Robot) -> ca.SX:
        return spring_energy(robot.position, robot.velocity, stiffness=3.0)

    def energy(self, x: Array, coordinates: int) -> float:
        p, v = x[:coordinates], x[coordinates : 2 * coordinates]
        return float(np.hypot.reduce(v) ** 2 / 2 + 1.5 * np.hypot.reduce(p) ** 2)


@pytest.mark.parametrize("name", ["damped point", "drag point", "two points", "joint chain"])
def test_power_is_dissipated_or_stored_as_kinetic_energy(name: str) -> None:
    """h_u ≥ 0 whatever the input: these robots are passive by themselves, with V = ½‖v‖²."""
    robot = ROBOTS[name].build(0.0, 0.0)
    h_u = columns([robot.system.x, robot.system.u], power_margin(robot.system, kinetic_energy(robot.velocity)))
    for x, u in held_inputs(ROBOTS[name], robot, 7):
        assert h_u(x[:, None], u[:, None])[0, 0] >= -1e-9


@pytest.mark.parametrize("name", ["lagged point", "saturating point"])
def test_what_comes_late_or_not_at_all_is_not_passive_by_itself(name: str) -> None:
    robot = ROBOTS[name].build(0.0, 0.0)
    h_u = columns([robot.system.x, robot.system.u], power_margin(robot.system, kinetic_energy(robot.velocity)))
    lowest = min(h_u(x[:, None], u[:, None])[0, 0] for x, u in held_inputs(ROBOTS[name], robot, 7))
    assert lowest < -10
