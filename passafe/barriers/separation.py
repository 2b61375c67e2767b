"""A distance that two robots keep from one another."""

import casadi as ca

from passafe.arguments.numbers import one_number
from passafe.arguments.ranges import require_positive
from passafe.errors import ShapeError


def separation(position: ca.SX, other: ca.SX, *, distance: float) -> ca.SX:
    """Return h = ‖p − q‖² − distance², m²: non-negative while two points are that far apart.

    Convex in (p, q).

    Args:
        position: p, shape (k, 1), m.
        other: q, shape (k, 1), m.
        distance: Positive, m.

    Raises:
        ShapeError: Positions that are no columns of equal length.
        DesignError: A distance that is not positive and finite.
    """
    if not position.is_column() or position.shape != other.shape:
        got = f"shapes {position.shape} and {other.shape}"
        raise ShapeError("separation positions", got, "two columns of equal length")
    require_positive("separation distance", distance, "m")
    return ca.sumsqr(position - other) - one_number("separation distance", distance) ** 2
