"""Coordinates of a robot whose position is no place, such as joints or levels, as numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import casadi as ca

from passafe.models.robot import Robot

Numbers = tuple[float, ...]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class JointMotion:
    """Coordinates of a position and their speeds.

    Attributes:
        count: Number of coordinates; 0 for a robot that is drawn at places.
        motion: x → coordinates and speeds, 0 for a robot without a velocity.
    """

    count: int
    motion: ca.Function

    @classmethod
    def of(cls, robot: Robot, drawn: int) -> Self:
        """Compile a robot's.

        Args:
            robot: The robot.
            drawn: Number of places in the plane at which it is drawn.
        """
        rows = 0 if drawn else int(robot.position.numel())
        speeds = robot.velocity if robot.velocity.numel() else ca.SX.zeros(robot.position.numel())
        parts = [ca.densify(robot.position), ca.densify(speeds)]
        return cls(count=rows, motion=ca.Function("motion", [robot.system.x], parts))

    def at(self, x: Sequence[float], u: Sequence[float]) -> tuple[Numbers, Numbers, Numbers]:
        """Return coordinates, speeds and efforts; none of the last where there is not one input for each coordinate."""
        places, speeds = (tuple(part.elements()) for part in self.motion(list(x)))
        return places, speeds, tuple(u) if len(u) == self.count else ()
