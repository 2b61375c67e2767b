"""The search for the input that is its own answer: tangents and margins made at it lead back to it.

Anderson's acceleration of u ← answer(u) (Walker & Ni 2011): plain iteration oscillates, or even diverges, where a row
is bent and the answer is far from what was asked for.
"""

from typing import Final

import numpy as np

from passafe.numerics.fixed_order import least_squares, product
from passafe.numerics.workspace import Array

MEMORY: Final = 3
"""Number of earlier answers that are taken into account, at most."""

SMALLEST: Final = 1e-10
"""A change that adds less than this share of the largest to the others counts as none."""


class FixedPoint:
    """Proposes where to try next, from what was tried and answered."""

    def __init__(self) -> None:
        self._tried: list[Array] = []
        self._changes: list[Array] = []

    def next(self, tried: Array, answer: Array) -> Array:
        """Return where to try next, shape (m,).

        Args:
            tried: Input at which tangents and margins were made, shape (m,).
            answer: The answer that they led to, shape (m,).
        """
        self._tried = [*self._tried[-MEMORY:], tried.copy()]
        self._changes = [*self._changes[-MEMORY:], answer - tried]
        if len(self._tried) == 1:
            return answer.copy()
        steps, turns = np.diff(self._tried, axis=0).T, np.diff(self._changes, axis=0).T
        weights = least_squares(turns, self._changes[-1], SMALLEST)
        return np.asarray(answer - product(steps + turns, weights))
