"""An ellipse in the plane, an ellipsoid in space: to keep out of, or to stay in."""

from collections.abc import Sequence
from math import cos, sin

import casadi as ca

from passafe.arguments.ranges import require_finite, require_positive
from passafe.barriers.columns import column_like
from passafe.errors import DesignError

PLANE = 2


def ellipse_keep_out(
    position: ca.SX, *, centre: Sequence[float], semi_axes: Sequence[float], rotation_rad: float = 0.0
) -> ca.SX:
    """Return h = a²(‖D⁻¹ Rᵀ(p − centre)‖² − 1), m²: non-negative outside an ellipse.

    D has the semi-axes on its diagonal, R turns by ``rotation_rad``, and a is the shortest semi-axis: so the unit is
    the disk's, and with equal semi-axes it is the disk. Convex in p.

    Args:
        position: p, shape (k, 1), m.
        centre: k numbers, m.
        semi_axes: k positive numbers, m.
        rotation_rad: Angle from the first coordinate to the first semi-axis, counter-clockwise; in the plane only.

    Raises:
        ShapeError: Vectors with another number of coordinates.
        DesignError: Numbers that make no ellipse.
    """
    middle = column_like("ellipse centre", centre, position)
    lengths = column_like("ellipse semi_axes", semi_axes, position)
    for length in semi_axes:
        require_positive("ellipse semi_axes", length, "m")
    require_finite("ellipse rotation_rad", rotation_rad, "rad")
    along = position - middle
    if rotation_rad:
        if position.numel() != PLANE:
            raise DesignError("ellipse rotation_rad", rotation_rad, f"0 with {position.numel()} coordinates")
        c, s = cos(rotation_rad), sin(rotation_rad)
        along = ca.vertcat(c * along[0] + s * along[1], -s * along[0] + c * along[1])
    shortest = min(semi_axes)
    return ca.sumsqr(along * (shortest / lengths)) - shortest**2


def ellipse_keep_in(
    position: ca.SX, *, centre: Sequence[float], semi_axes: Sequence[float], rotation_rad: float = 0.0
) -> ca.SX:
    """Return h = a²(1 − ‖D⁻¹ Rᵀ(p − centre)‖²), m²: non-negative inside an ellipse.

    Concave in p; see ``ellipse_keep_out`` for the symbols.

    Args:
        position: p, shape (k, 1), m.
        centre: k numbers, m.
        semi_axes: k positive numbers, m.
        rotation_rad: Angle from the first coordinate to the first semi-axis, counter-clockwise; in the plane only.

    Raises:
        ShapeError: Vectors with another number of coordinates.
        DesignError: Numbers that make no ellipse.
    """
    return -ellipse_keep_out(position, centre=centre, semi_axes=semi_axes, rotation_rad=rotation_rad)
