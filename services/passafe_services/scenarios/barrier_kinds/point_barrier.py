"""Bases of barriers of points in the plane: of each point that the robot moves, or of the one that is named."""

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, ClassVar, Self

import casadi as ca
from pydantic import Field

from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.barrier_kind import BarrierKind, SingleBarrier
from passafe_services.scenarios.barrier_kinds.motion import Motion
from passafe_services.scenarios.barrier_kinds.outline import Outline
from passafe_services.scenarios.robot_models import RobotModel


class PointKind(BarrierKind):
    """A barrier of each point, or of one.

    Attributes:
        point: Number of the point it holds for, from 1; every point by default.
    """

    least_points: ClassVar[int] = 1

    point: Annotated[int, Field(ge=1, le=2)] | None = None

    def of_each_point(self, model: RobotModel) -> Iterator[Self]:
        """Yield the barrier for every point that it holds for, numbered in its name where there are several.

        Raises:
            ValueError: The model does not move the point.
        """
        if self.point is not None and self.point > model.points:
            got = f"point {self.point} of barrier {self.name!r} with model {model.name!r}"
            raise ValueError(f"filter.barriers: got {got}, allowed 1 to {model.points}")
        for point in range(1, model.points + 1) if self.point is None else (self.point,):
            numbered = self.point is None and model.points > 1
            name = f"{self.name} {point}" if numbered else self.name
            yield self.model_copy(update={"name": name, "point": point})


class PointBarrier(PointKind, SingleBarrier):
    """A barrier with one h of the position or the velocity of a point."""

    def split(self, model: RobotModel) -> Iterator[SingleBarrier]:
        """Yield the barrier for every point that it holds for."""
        yield from self.of_each_point(model)

    def of_point(self, coordinates: ca.SX) -> ca.SX:
        """Return the point's two coordinates of a position or a velocity, shape (2, 1)."""
        first = 2 * ((self.point or 1) - 1)
        return coordinates[first : first + 2]


class PlaceBarrier(PointBarrier):
    """A set of places that a point keeps out of or stays in; the set may move.

    A kind defines ``h_at``, ``still_outline`` and ``h_unit``; the motion is taken care of here.

    Attributes:
        motion: Displacement of the set as a function of plant time; none by default.
    """

    motion: Motion | None = None

    @abstractmethod
    def h_at(self, position: ca.SX) -> ca.SX:
        """Return h of a position, shape (2, 1), m, relative to the set before it has moved."""

    @abstractmethod
    def still_outline(self) -> Outline:
        """Return the outline of the set before it has moved."""

    def h(self, robot: Robot) -> ca.SX:
        """Return h_at(p − d(t)), p the point's position and d the displacement."""
        position = self.of_point(robot.position)
        if self.motion is not None:
            position = position - self.motion.displacement(robot.system.t)
        return self.h_at(position)

    @property
    def outline(self) -> Outline:
        """Return the outline with its motion."""
        return replace(self.still_outline(), motion=self.motion)
