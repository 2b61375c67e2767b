"""Ellipses: ``ellipse-keep-out`` and ``ellipse-keep-in``."""

from typing import Annotated, ClassVar, Literal

import casadi as ca
from pydantic import Field

from passafe.barriers.ellipse import ellipse_keep_in, ellipse_keep_out
from passafe_services.scenarios.barrier_kinds.outline import Outline, ellipse_border
from passafe_services.scenarios.barrier_kinds.point_barrier import PlaceBarrier
from passafe_services.scenarios.fields import Finite, Place, Positive


class EllipseBarrier(PlaceBarrier):
    """An ellipse to keep out of, h = a²(‖D⁻¹Rᵀ(p − centre)‖² − 1), m², or to stay in, −h.

    D has the semi-axes on its diagonal, a is the shorter one, R turns by ``rotation_rad``, counter-clockwise.

    Attributes:
        centre: Centre before it has moved, m.
        semi_axes_m: Lengths of the first and the second semi-axis, m.
        rotation_rad: Angle from the first coordinate to the first semi-axis, rad.
    """

    h_unit: ClassVar[str] = "m²"

    kind: Literal["ellipse-keep-out", "ellipse-keep-in"]
    centre: Place
    semi_axes_m: Annotated[tuple[Positive, ...], Field(min_length=2, max_length=2)]
    rotation_rad: Finite = 0.0

    def h_at(self, position: ca.SX) -> ca.SX:
        """Return h of a position."""
        ellipse = ellipse_keep_out if self.kind == "ellipse-keep-out" else ellipse_keep_in
        return ellipse(position, centre=self.centre, semi_axes=self.semi_axes_m, rotation_rad=self.rotation_rad)

    def still_outline(self) -> Outline:
        """Return the ellipse."""
        c1, c2 = self.centre
        outline = Outline.keep_out if self.kind == "ellipse-keep-out" else Outline.keep_in
        return outline(ellipse_border(self.centre, self.semi_axes_m, self.rotation_rad), (c1, c2))
