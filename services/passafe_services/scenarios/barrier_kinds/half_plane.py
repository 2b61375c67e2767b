"""One side of a line: ``half-plane``."""

from typing import ClassVar, Literal, Self

import casadi as ca
from pydantic import model_validator

from passafe.barriers.half_plane import half_plane
from passafe_services.scenarios.barrier_kinds.outline import Outline
from passafe_services.scenarios.barrier_kinds.point_barrier import PlaceBarrier
from passafe_services.scenarios.fields import Finite, Place


class HalfPlaneBarrier(PlaceBarrier):
    """A side of a line to stay on: h = normalᵀp − offset; m where the normal has unit length.

    Attributes:
        normal: Normal of the line, to the safe side.
        offset: Value of normalᵀp on the line, before it has moved.
    """

    h_unit: ClassVar[str] = "m"

    kind: Literal["half-plane"]
    normal: Place
    offset: Finite

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.normal):
            raise ValueError(f"normal: got {self.normal}, allowed a vector that is not zero")
        return self

    def h_at(self, position: ca.SX) -> ca.SX:
        """Return h of a position."""
        return half_plane(position, normal=self.normal, offset=self.offset)

    def still_outline(self) -> Outline:
        """Return the line and the side behind it."""
        return Outline.half_plane(self.normal, self.offset)
