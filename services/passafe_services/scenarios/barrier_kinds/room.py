"""Rooms with four walls along the axes: ``room``."""

from collections.abc import Iterator
from typing import Final, Literal, Self

from pydantic import model_validator

from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.half_plane import HalfPlaneBarrier
from passafe_services.scenarios.barrier_kinds.point_barrier import PointKind
from passafe_services.scenarios.fields import Place, require_above
from passafe_services.scenarios.robot_models import RobotModel

_WALLS: Final = (("left", 0, 1.0), ("right", 0, -1.0), ("bottom", 1, 1.0), ("top", 1, -1.0))
"""Name of each wall, the axis across it, and the sign of its normal on that axis."""


class RoomBarrier(PointKind):
    """A room to stay in: four half-planes, ``<name> left``, ``right``, ``bottom`` and ``top``; h in m.

    Attributes:
        low_m: Lowest corner, m.
        high_m: Highest corner, m.
    """

    kind: Literal["room"]
    low_m: Place
    high_m: Place

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        require_above("low_m, high_m", self.low_m, self.high_m)
        return self

    def split(self, model: RobotModel) -> Iterator[SingleBarrier]:
        """Yield the walls for every point."""
        for room in self.of_each_point(model):
            for side, axis, sign in _WALLS:
                corner = room.low_m if sign > 0 else room.high_m
                yield HalfPlaneBarrier.model_construct(
                    kind="half-plane",
                    name=f"{room.name} {side}",
                    class_k=room.class_k,
                    point=room.point,
                    motion=None,
                    normal=(sign, 0.0) if axis == 0 else (0.0, sign),
                    offset=sign * corner[axis],
                )
