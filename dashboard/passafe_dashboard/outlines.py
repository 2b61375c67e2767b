"""Obstacles as lines in the plane: their border, and what it shuts off.

A region without a border that closes is drawn as far as ``EXTENT_M``; charts show only what is near the robot.
"""

from math import cos, hypot, pi, sin
from typing import Final, TypeAlias

from passafe_dashboard.obstacles import Disk, Ellipse, HalfPlane, Region

EXTENT_M: Final = 100.0
CORNERS: Final = 96
"""Of the polygon that stands for an ellipse: it is off by less than a thousandth of the longer semi-axis."""

Line: TypeAlias = tuple[tuple[float, float], ...]


def border(region: Region) -> Line:
    """Line between safe and unsafe, before the region has moved, m; closed if the region is bounded."""
    if isinstance(region, HalfPlane):
        return half_plane_corners(region)[:2]
    c1, c2 = region.centre
    a1, a2 = region.semi_axes if isinstance(region, Ellipse) else (region.radius, region.radius)
    turn = region.rotation_rad if isinstance(region, Ellipse) else 0.0
    c, s = cos(turn), sin(turn)
    points = []
    for k in range(CORNERS + 1):
        angle = 2 * pi * k / CORNERS
        w1, w2 = a1 * cos(angle), a2 * sin(angle)
        points.append((c1 + c * w1 - s * w2, c2 + s * w1 + c * w2))
    return tuple(points)


def unsafe_side(region: Region) -> Line:
    """Polygon of what must not be entered, before it has moved, m.

    Outside of a disk or an ellipse to stay in it is a square with a hole: its line runs around the square, along a
    cut to the border, backwards around that, and back.
    """
    if isinstance(region, HalfPlane):
        return half_plane_corners(region)
    rim = border(region)
    if not region.keep_in:
        return rim
    c1, c2 = region.centre
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1))
    square = tuple((c1 + sign_1 * EXTENT_M, c2 + sign_2 * EXTENT_M) for sign_1, sign_2 in corners)
    return square + rim[::-1]


def reference(region: Region) -> tuple[float, float]:
    """A place that moves with the region and stands for it, m: a centre, a foot on the border."""
    if isinstance(region, Disk | Ellipse):
        return region.centre[0], region.centre[1]
    n1, n2 = region.normal
    square = n1 * n1 + n2 * n2
    return n1 * region.offset / square, n2 * region.offset / square


def shifted(line: Line, by: tuple[float, float]) -> Line:
    """Return a line moved by a displacement, m."""
    return tuple((p1 + by[0], p2 + by[1]) for p1, p2 in line)


def half_plane_corners(plane: HalfPlane) -> Line:
    """Corners of a rectangle that covers the forbidden side normalᵀp < offset near the origin, m.

    The first two lie on the line normalᵀp = offset, about its point nearest to the origin.
    """
    n1, n2 = plane.normal
    length = hypot(n1, n2)
    f1, f2 = reference(plane)
    n1, n2 = n1 / length, n2 / length
    along, behind = EXTENT_M, EXTENT_M
    return (
        (f1 - n2 * along, f2 + n1 * along),
        (f1 + n2 * along, f2 - n1 * along),
        (f1 + n2 * along - n1 * behind, f2 - n1 * along - n2 * behind),
        (f1 - n2 * along - n1 * behind, f2 + n1 * along - n2 * behind),
    )
