"""A disk in the plane, a ball in space: to keep out of, or to stay in."""

from collections.abc import Sequence

import casadi as ca

from passafe.arguments.numbers import one_number
from passafe.arguments.ranges import require_positive
from passafe.barriers.columns import column_like


def disk_keep_out(position: ca.SX, *, centre: Sequence[float], radius: float) -> ca.SX:
    """Return h = ‖p − centre‖² − radius², m²: non-negative outside a disk or ball (paper, section 4).

    Convex in p.

    Args:
        position: p, shape (k, 1), m.
        centre: k numbers, m.
        radius: Positive, m.

    Raises:
        ShapeError: A centre with another number of coordinates.
        DesignError: Numbers that make no disk.
    """
    return -disk_keep_in(position, centre=centre, radius=radius)


def disk_keep_in(position: ca.SX, *, centre: Sequence[float], radius: float) -> ca.SX:
    """Return h = radius² − ‖p − centre‖², m²: non-negative inside a disk or ball.

    Concave in p; ∂h/∂p vanishes at the centre, where h is largest and its rows ask for nothing.

    Args:
        position: p, shape (k, 1), m.
        centre: k numbers, m.
        radius: Positive, m.

    Raises:
        ShapeError: A centre with another number of coordinates.
        DesignError: Numbers that make no disk.
    """
    middle = column_like("disk centre", centre, position)
    require_positive("disk radius", radius, "m")
    return one_number("disk radius", radius) ** 2 - ca.sumsqr(position - middle)
