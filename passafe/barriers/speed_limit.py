"""A limit on the speed, whatever its direction."""

import casadi as ca

from passafe.arguments.numbers import one_number
from passafe.arguments.ranges import require_positive
from passafe.barriers.columns import require_column


def speed_limit(velocity: ca.SX, *, limit: float) -> ca.SX:
    """Return h = limit² − ‖v‖², (m/s)²: non-negative up to the limit.

    Concave in v; ∂h/∂v vanishes at rest, where h is largest and its row asks for nothing.

    Args:
        velocity: v, shape (k, 1), m/s.
        limit: Positive, m/s.

    Raises:
        ShapeError: A velocity that is no column.
        DesignError: A limit that is not positive and finite.
    """
    require_column("speed limit velocity", velocity)
    require_positive("speed limit", limit, "m/s")
    return one_number("speed limit", limit) ** 2 - ca.sumsqr(velocity)
