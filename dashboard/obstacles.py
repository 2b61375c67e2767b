"""Obstacles of a scenario as shapes in the robot's plane: what to draw, and the barrier h as measured.

A barrier of a scenario is a condition on the robot's position, which is the first part of the model's state;
see ``services/scenarios/schema.py``. What stands still and is no ellipse is evaluated in plain numbers here, the rest
as the core does it. Evaluating h from a plant state needs nothing of the filter, so the page
can show what the filter believes beside what the robot did.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import casadi as ca

from passafe.models.robot import Robot
from services.scenarios.barriers import barrier_function
from services.scenarios.design import robot_of
from services.scenarios.schema import BarrierConfig, DiskBarrier, HalfPlaneBarrier, Scenario


@dataclass(frozen=True, kw_only=True, slots=True)
class Disk:
    """A disk that the robot keeps out of: h = ‖p − centre‖² − radius², m²."""

    name: str
    centre: tuple[float, ...]
    radius: float

    def h(self, x: Sequence[float], _t_s: float = 0.0) -> float:
        """Barrier value at a state that begins with the position's coordinates, m²."""
        square = 0.0
        for p, c in zip(x, self.centre, strict=False):
            square += (p - c) * (p - c)
        return square - self.radius * self.radius


@dataclass(frozen=True, kw_only=True, slots=True)
class HalfPlane:
    """A side of a line that the robot stays on: h = normalᵀp − offset; m when the normal has unit length."""

    name: str
    normal: tuple[float, ...]
    offset: float

    def h(self, x: Sequence[float], _t_s: float = 0.0) -> float:
        """Barrier value at a state that begins with the position's coordinates."""
        product = 0.0
        for p, n in zip(x, self.normal, strict=False):
            product += p * n
        return product - self.offset


@dataclass(frozen=True, kw_only=True, slots=True)
class Undrawn:
    """A barrier with h alone: it moves, or is no set of positions, or has another shape.

    Attributes:
        name: The barrier's.
        evaluate: From x and plant time, s, to h.
        unit: Of h.
    """

    name: str
    evaluate: ca.Function
    unit: str

    def h(self, x: Sequence[float], t_s: float = 0.0) -> float:
        """Barrier value at a state and a plant time."""
        return float(self.evaluate(ca.DM(list(x)), t_s))


Obstacle: TypeAlias = Disk | HalfPlane | Undrawn

UNITS: Final = {
    "disk-keep-out": "m²",
    "disk-keep-in": "m²",
    "ellipse-keep-out": "m²",
    "ellipse-keep-in": "m²",
    "half-plane": "m",
    "speed-limit": "m²/s²",
    "lower-limit": "unit of x",
    "upper-limit": "unit of x",
    "keep-apart": "m²",
}


def obstacles_of(scenario: Scenario) -> tuple[Obstacle, ...]:
    """Shapes of a scenario's barriers, in the scenario's order."""
    robot = robot_of(scenario)
    return tuple(_obstacle(barrier, robot) for barrier in scenario.filter.barriers)


def _obstacle(barrier: BarrierConfig, robot: Robot) -> Obstacle:
    if isinstance(barrier, DiskBarrier) and barrier.kind == "disk-keep-out" and barrier.motion is None:
        return Disk(name=barrier.name, centre=barrier.centre, radius=barrier.radius)
    if isinstance(barrier, HalfPlaneBarrier):
        return HalfPlane(name=barrier.name, normal=barrier.normal, offset=barrier.offset)
    system = robot.system
    evaluate = ca.Function("h", [system.x, system.t], [barrier_function(barrier, robot)])
    return Undrawn(name=barrier.name, evaluate=evaluate, unit=UNITS[barrier.kind])


def unit_of_h(obstacle: Obstacle) -> str:
    """Unit of an obstacle's h, as an axis label says it."""
    if isinstance(obstacle, Undrawn):
        return obstacle.unit
    return "m²" if isinstance(obstacle, Disk) else "m"
