"""A box whose sides follow the axes: a room for a position, limits for joints, limits for their speeds."""

from collections.abc import Sequence

import casadi as ca

from passafe.barriers.columns import column_like
from passafe.errors import DesignError


def box(coordinates: ca.SX, *, low: Sequence[float], high: Sequence[float]) -> tuple[ca.SX, ...]:
    """Return h = qᵢ − lowᵢ and h = highᵢ − qᵢ of every coordinate, in that order: 2k barriers, one for each side.

    One barrier a side, because each has a gradient that vanishes nowhere. Their product (q − low)(high − q) would be
    one barrier for two sides, but its gradient is zero half-way between them, where no input could keep ψ_r ≥ 0 at
    speed; the least of them has a kink. The filter takes any number of rows.

    Args:
        coordinates: q, shape (k, 1): a position, joint angles, or their velocities.
        low: k numbers, units of q.
        high: k numbers, each above its ``low``.

    Raises:
        ShapeError: Another number of coordinates.
        DesignError: Numbers that make no box.
    """
    least = column_like("box low", low, coordinates)
    most = column_like("box high", high, coordinates)
    if any(top <= bottom for bottom, top in zip(low, high, strict=True)):
        raise DesignError("box low, high", f"{list(low)}, {list(high)}", "every high above its low")
    sides = []
    for i in range(coordinates.numel()):
        sides += [coordinates[i] - least[i], most[i] - coordinates[i]]
    return tuple(sides)
