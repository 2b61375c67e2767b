"""An input well inside all limits, by projections onto one limit after the other (Bauschke & Borwein 1996)."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.numerics.fixed_order import inner, length
from passafe.numerics.workspace import Array

INSETS: Final = (0.3, 0.1, 0.03, 1e-2, 1e-3, 1e-4)
"""By how much the limits are drawn in, one after the other: shares of a ball's radius, or of half the shortest axis."""

SWEEPS: Final = 400
"""Projections onto all limits, at most, for each inset."""


def interior_point(
    low: Sequence[float], high: Sequence[float], norms: Sequence[NormBound], half_spaces: Sequence[HalfSpace]
) -> tuple[float, ...] | None:
    """Return an input inside all limits, or ``None`` if none was found, which is rare where there is one.

    The middle of the axes, if that will do.

    Args:
        low: Least input of each axis.
        high: Largest input of each axis.
        norms: Balls over some axes.
        half_spaces: Half-spaces.
    """
    least, most = np.array(low), np.array(high)
    u = least / 2 + most / 2
    if not norms and not half_spaces:
        return tuple(u.tolist())
    for inset in INSETS:
        room = inset * float((most - least).min()) / 2
        found = u.copy()
        for _ in range(SWEEPS):
            before = found
            found = _projected(found, norms, half_spaces, inset, room)
            found = np.clip(found, least + room, most - room)
            if np.array_equal(found, before):
                break
        if _is_inside(found, norms, half_spaces):
            return tuple(found.tolist())
    return None


def _projected(
    u: Array, norms: Sequence[NormBound], half_spaces: Sequence[HalfSpace], inset: float, room: float
) -> Array:
    for half_space in half_spaces:
        weights = np.array(half_space.weights)
        u = u - max(inner(weights, u) - half_space.bound + room, 0.0) * weights
    for norm in norms:
        axes = list(norm.axes)
        size = length(u[axes])
        if size > (1 - inset) * norm.bound:
            u = u.copy()
            u[axes] *= (1 - inset) * norm.bound / size
    return u


def _is_inside(u: Array, norms: Sequence[NormBound], half_spaces: Sequence[HalfSpace]) -> bool:
    in_balls = all(length(u[list(norm.axes)]) < norm.bound for norm in norms)
    return in_balls and all(inner(np.array(each.weights), u) < each.bound for each in half_spaces)
