"""Outlines of barriers in the plane: the border of the safe set, the side that is unsafe, and its motion."""

from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import Final, Self, TypeAlias

import numpy as np

from passafe_services.scenarios.barrier_kinds.motion import FloatArray, Motion

EXTENT_M: Final = 100.0
"""Distance at which the outline of a set without an end stops; charts show only what is near the robot."""

CORNERS: Final = 96
"""Of the polygon that stands for an ellipse: it is off by less than a thousandth of the longer semi-axis."""

Polyline: TypeAlias = tuple[tuple[float, float], ...]
"""Places in the plane, m, joined by straight lines."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Outline:
    """A barrier in the plane.

    Attributes:
        border: Line h = 0 before the barrier has moved; its last place is its first where it closes.
        unsafe: Polygon of h < 0 before the barrier has moved, as far as it is drawn.
        reference: Place that stands for the barrier and moves with it, m.
        motion: Displacement as a function of plant time.
    """

    border: Polyline
    unsafe: Polyline
    reference: tuple[float, float]
    motion: Motion | None = None

    @classmethod
    def keep_out(cls, border: Polyline, reference: tuple[float, float]) -> Self:
        """Return the outline of a set to keep out of, inside a border that closes."""
        return cls(border=border, unsafe=border, reference=reference)

    @classmethod
    def keep_in(cls, border: Polyline, reference: tuple[float, float]) -> Self:
        """Return the outline of a set to stay in, inside a border that closes.

        The unsafe side is a square with a hole: its line runs around the square, along a cut to the border,
        backwards around that, and back.
        """
        corners = ((1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1))
        square = tuple((reference[0] + a * EXTENT_M, reference[1] + b * EXTENT_M) for a, b in corners)
        return cls(border=border, unsafe=square + border[::-1], reference=reference)

    @classmethod
    def half_plane(cls, normal: tuple[float, ...], offset: float) -> Self:
        """Return the outline of normalᵀp ≥ offset: a rectangle covers the unsafe side.

        Its border runs through the point of the line that is nearest to the origin.
        """
        n1, n2 = normal
        square, length = n1 * n1 + n2 * n2, hypot(n1, n2)
        f1, f2 = n1 * offset / square, n2 * offset / square
        n1, n2 = n1 / length * EXTENT_M, n2 / length * EXTENT_M
        border = (f1 - n2, f2 + n1), (f1 + n2, f2 - n1)
        behind = (f1 + n2 - n1, f2 - n1 - n2), (f1 - n2 - n1, f2 + n1 - n2)
        return cls(border=border, unsafe=border + behind, reference=(f1, f2))

    @property
    def is_closed(self) -> bool:
        """Return whether the border closes, so that a picture can hold it."""
        return self.border[0] == self.border[-1]

    @property
    def is_bounded(self) -> bool:
        """Return whether the unsafe side is what the border encloses."""
        return self.unsafe == self.border

    def displacements_m(self, t_s: FloatArray) -> FloatArray:
        """Return the displacement at N plant times, s, shape (2, N), m; zero without a motion."""
        return np.zeros((2, t_s.size)) if self.motion is None else self.motion.displacements_m(t_s)


def ellipse_border(centre: tuple[float, ...], semi_axes: tuple[float, ...], rotation_rad: float = 0.0) -> Polyline:
    """Return the border of an ellipse as a polygon of ``CORNERS`` corners on it, m.

    Args:
        centre: Two numbers, m.
        semi_axes: Two numbers, m.
        rotation_rad: Angle from the first coordinate to the first semi-axis, counter-clockwise.
    """
    (c1, c2), (a1, a2) = centre, semi_axes
    c, s = cos(rotation_rad), sin(rotation_rad)
    corners = []
    for k in range(CORNERS):
        w1, w2 = a1 * cos(2 * pi * k / CORNERS), a2 * sin(2 * pi * k / CORNERS)
        corners.append((c1 + c * w1 - s * w2, c2 + s * w1 + c * w2))
    return (*corners, corners[0])
