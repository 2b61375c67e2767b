"""One side of a line in the plane, of a plane in space."""

from collections.abc import Sequence

import casadi as ca

from passafe.arguments.ranges import require_finite
from passafe.barriers.columns import column_like
from passafe.errors import DesignError


def half_plane(position: ca.SX, *, normal: Sequence[float], offset: float) -> ca.SX:
    """Return h = normalᵀp − offset: non-negative on the side that ``normal`` points to.

    Args:
        position: p, shape (k, 1), m.
        normal: k numbers, not all zero.
        offset: Units of normalᵀp.

    Raises:
        ShapeError: A normal with another number of coordinates.
        DesignError: Numbers that make no half-plane.
    """
    direction = column_like("half-plane normal", normal, position)
    if not any(normal):
        raise DesignError("half-plane normal", list(normal), "a vector that is not zero")
    require_finite("half-plane offset", offset, "units of normalᵀp")
    return ca.dot(direction, position) - offset
