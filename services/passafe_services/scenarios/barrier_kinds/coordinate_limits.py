"""Limits of every coordinate of the position or the velocity, as joints have them: ``coordinate-limits``."""

from collections.abc import Iterator
from typing import Literal, Self

import casadi as ca
from pydantic import model_validator

from passafe.barriers.half_plane import half_plane
from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe_services.scenarios.barrier_kinds.barrier_kind import BarrierKind, SingleBarrier
from passafe_services.scenarios.fields import Vector, require_above
from passafe_services.scenarios.robot_models import RobotModel


class CoordinateLimit(SingleBarrier):
    """One side of the limits of one coordinate q: h = q − bound, or bound − q for an upper limit.

    Attributes:
        of: Quantity that q is one coordinate of.
        index: Number of the coordinate, from 0.
        bound: In q's unit.
        upper: Whether q stays below the bound.
        unit: Of q.
    """

    kind: Literal["coordinate-limits"]
    of: Literal["position", "velocity"]
    index: int
    bound: float
    upper: bool
    unit: str

    @property
    def h_unit(self) -> str:
        """Return the coordinate's unit."""
        return self.unit

    @property
    def is_of_position(self) -> bool:
        """Return whether q is a coordinate of the position."""
        return self.of == "position"

    def h(self, robot: Robot) -> ca.SX:
        """Return h of the coordinate.

        Raises:
            DesignError: The robot has fewer coordinates.
        """
        coordinates = robot.position if self.of == "position" else robot.velocity
        if self.index >= coordinates.numel():
            allowed = f"1 to {coordinates.numel()}" if coordinates.numel() else f"a robot with a {self.of}"
            raise DesignError(f"barrier {self.name!r}", f"{self.of} coordinate {self.index + 1}", allowed)
        sign = -1.0 if self.upper else 1.0
        return half_plane(coordinates[self.index], normal=(sign,), offset=sign * self.bound)


class CoordinatesBarrier(BarrierKind):
    """Limits between which every coordinate of the position or the velocity stays.

    Two barriers for coordinate i, counted from 1: ``<name> <i> low`` with h = qᵢ − low, ``<name> <i> high`` with
    h = high − qᵢ, in the coordinate's unit.

    Attributes:
        of: Quantity that is limited.
        low: Lowest value of each coordinate, m or rad, or per second.
        high: Highest value of each coordinate.
    """

    kind: Literal["coordinate-limits"]
    of: Literal["position", "velocity"] = "position"
    low: Vector
    high: Vector

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        require_above("low, high", self.low, self.high)
        return self

    def split(self, model: RobotModel) -> Iterator[SingleBarrier]:
        """Yield the lower and the upper limit of every coordinate."""
        unit = model.position_unit + ("/s" if self.of == "velocity" else "")
        for index, bounds in enumerate(zip(self.low, self.high, strict=True)):
            for side, bound in zip(("low", "high"), bounds, strict=True):
                yield CoordinateLimit.model_construct(
                    kind="coordinate-limits",
                    name=f"{self.name} {index + 1} {side}",
                    class_k=self.class_k,
                    of=self.of,
                    index=index,
                    bound=bound,
                    upper=side == "high",
                    unit=unit,
                )
