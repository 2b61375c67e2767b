"""A robot's body in space as numbers: the points of its drawing and the spheres that cover it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import casadi as ca

from passafe.models.robot import Robot

Spot = tuple[float, float, float]
"""A place in space, in the frame of the robot's base, m."""

SPACE = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyInSpace:
    """Points and spheres of a robot that is drawn in space.

    Attributes:
        links: Pairs of points that a line joins.
        radii: Radius of each sphere, m.
        points: Number of points.
        spots: x → all points, then the centres of all spheres.
    """

    links: tuple[tuple[int, int], ...]
    radii: tuple[float, ...]
    points: int
    spots: ca.Function

    @classmethod
    def of(cls, robot: Robot) -> Self | None:
        """Compile a robot's; ``None`` for one that is not drawn in space."""
        drawing = robot.drawing
        if drawing is None or drawing.dimensions != SPACE:
            return None
        spots = ca.vertcat(drawing.points, *(sphere.centre for sphere in robot.spheres))
        return cls(
            links=drawing.links,
            radii=tuple(sphere.radius_m for sphere in robot.spheres),
            points=drawing.count,
            spots=ca.Function("spots", [robot.system.x], [ca.densify(spots)]),
        )

    def at(self, x: Sequence[float]) -> tuple[list[Spot], list[Spot]]:
        """Return the points and the centres of the spheres at a state."""
        numbers = self.spots(list(x)).elements()
        spots = list(zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True))
        return spots[: self.points], spots[self.points :]
