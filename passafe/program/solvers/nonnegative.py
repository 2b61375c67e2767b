"""Non-negative least squares: the active-set method of Lawson & Hanson (1974), chapter 23."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.numerics.fixed_order import inner, least_squares, length, product
from passafe.numerics.workspace import Array

STEPS: Final = 3
"""Unknowns that enter, at most, for each that there is."""

ROUNDING: Final = 1e-14
"""Slope of a column, relative to its length and to what it is the difference of, that counts as none."""


def nonnegative_least_squares(A: Array, b: Array) -> Array | None:
    """Return the x ≥ 0 for which ‖A x − b‖ is least, or ``None`` if it is not found in ``STEPS`` rounds.

    Args:
        A: Finite, shape (m, n).
        b: Finite, shape (m,).
    """
    count = A.shape[1]
    x, is_free, is_barred = np.zeros(count), np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    lengths = np.sqrt(np.add.reduce(A * A, axis=0))
    for _ in range(STEPS * count):
        rounding = ROUNDING * (length(b) + inner(lengths, x)) * lengths
        slope = np.where(is_free | is_barred, -np.inf, product(b - product(A, x), A) - rounding)
        entering = int(slope.argmax())
        if not slope[entering] > 0.0:
            return x
        is_free[entering] = True
        x = _within(A, b, x, is_free)
        if is_free[entering]:
            is_barred[:] = False
        else:  # its slope was rounding
            is_barred[entering] = True
    return None


def _within(A: Array, b: Array, x: Array, is_free: NDArray[np.bool_]) -> Array:
    """Return the best x ≥ 0 that is zero where it is not free, by taking away from ``is_free`` what is zero there."""
    while True:
        best = np.zeros(len(x))
        best[is_free] = least_squares(A[:, is_free], b)
        leaving = is_free & (best <= 0.0)
        if not leaving.any():
            return best
        way = x[leaving] - best[leaving]
        share = float(np.divide(x[leaving], way, out=np.zeros(len(way)), where=way > 0.0).min())
        x = x + share * (best - x)
        is_free &= x > ROUNDING * x.max()
        x = np.where(is_free, x, 0.0)
