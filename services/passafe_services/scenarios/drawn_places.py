"""Places at which a robot is drawn in the plane, as numbers: of a state, or of many at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.models.robot import Robot

FloatArray: TypeAlias = NDArray[np.float64]

Pair: TypeAlias = tuple[float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class DrawnPlaces:
    """Points of a robot in the plane, the angle of its body, and how its input pushes them.

    Attributes:
        count: Number of points; 0 for a robot that is not drawn in the plane.
        outline: Corners of the body in its own frame, m; empty for a robot without one.
        links: Pairs of points that a line joins.
        has_heading: Whether the body has an angle.
        places: x → all points, the angle if there is one, and the velocities of the position's points, 0 for a robot
            that has none.
        pushes: x → effect of the input on the acceleration of the position's points, or on the first rate that it
            reaches, shape (2·points, m); ``None`` where the input is that acceleration itself, up to a factor.
    """

    count: int
    outline: tuple[Pair, ...]
    links: tuple[tuple[int, int], ...]
    has_heading: bool
    places: ca.Function
    pushes: ca.Function | None

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """Compile a robot's."""
        drawing, x = robot.drawing, robot.system.x
        in_plane = drawing is not None and drawing.dimensions == 2  # noqa: PLR2004 - the plane
        points = drawing.points if drawing is not None and in_plane else robot.position[: 2 * robot.points]
        outline = drawing.outline if drawing is not None and in_plane else ()
        heading = drawing.heading if drawing is not None and outline else ca.SX(0, 1)
        speeds = robot.velocity[: 2 * robot.points] if robot.velocity.numel() else ca.SX.zeros(2 * robot.points)
        return cls(
            count=int(points.numel()) // 2,
            outline=outline,
            links=drawing.links if drawing is not None and in_plane else (),
            has_heading=bool(outline),
            places=ca.Function("places", [x], [ca.densify(ca.vertcat(points, heading)), ca.densify(speeds)]),
            pushes=_pushes(robot),
        )

    def at(self, x: Sequence[float]) -> tuple[list[Pair], float | None, list[Pair]]:
        """Return the points, m, the angle of the body, rad, and velocities, m/s, at a state."""
        numbers, speeds = (part.elements() for part in self.places(list(x)))
        return _pairs(numbers[: 2 * self.count]), numbers[-1] if self.has_heading else None, _pairs(speeds)

    def many(self, x: FloatArray) -> FloatArray:
        """Return points and angle at N states, shape (n, N): 2·count rows, and one for the angle if there is one."""
        samples = x.shape[1]
        if not samples:
            return np.zeros((2 * self.count + self.has_heading, 0))
        return np.asarray(self.places.map(samples)(x)[0].full())

    def push(self, x: Sequence[float], u: Sequence[float]) -> tuple[float, ...]:
        """Return the acceleration of the points by an input at a state, 2·points numbers, or the input itself."""
        if self.pushes is None:
            return tuple(u)
        return tuple((self.pushes(list(x)).full() @ np.asarray(u, dtype=float)).tolist())

    def reach(self, x: Sequence[float], point: int, towards: Pair) -> float:
        """Return how much input one unit of acceleration of a point towards a direction is made of."""
        if self.pushes is None:
            return 1.0
        effect = self.pushes(list(x)).full()[2 * point : 2 * point + 2]
        return float(np.linalg.norm(effect.T @ np.asarray(towards)))


def _pushes(robot: Robot) -> ca.Function | None:
    """Return the effect of the input on the first rate of the points' motion that it reaches, at u = 0.

    ``None`` where that is a multiple of the input itself, as of a point that is pushed by a force on each axis.
    """
    x, u, rows = robot.system.x, robot.system.u, 2 * robot.points
    moves, effect = robot.position[:rows], ca.SX.zeros(rows, robot.system.m)
    for _ in range(robot.system.n if rows else 0):
        moves = robot.system.lie_derivative(moves)
        effect = ca.densify(ca.substitute([ca.jacobian(moves, u)], [u], [ca.SX.zeros(robot.system.m)])[0])
        if not effect.is_zero():
            break
        moves = ca.substitute([moves], [u], [ca.SX.zeros(robot.system.m)])[0]
    return None if _is_multiple_of_one(effect) else ca.Function("pushes", [x], [effect])


def _is_multiple_of_one(effect: ca.SX) -> bool:
    """Return whether a matrix is a positive number times the identity."""
    if not effect.numel() or not effect.is_square() or not effect.is_constant():
        return False
    numbers = np.asarray(ca.DM(effect).full())
    return bool(numbers[0, 0] > 0 and np.allclose(numbers, numbers[0, 0] * np.eye(numbers.shape[0])))


def _pairs(numbers: Sequence[float]) -> list[Pair]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))
