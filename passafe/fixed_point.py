"""The search for the input that is its own answer: tangents and margins made at it lead back to it.

Anderson's acceleration of u ← answer(u) (Walker & Ni 2011): plain iteration oscillates, or even diverges, where a row
is bent and the answer is far from what was asked for.
"""

from typing import Final

import numpy as np

from passafe.workspace import Array

MEMORY: Final = 3
"""Number of earlier answers that are taken into account, at most."""

SMALLEST: Final = 1e-10
"""Singular values below this share of the largest count as zero."""


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
        weights = np.linalg.lstsq(turns, self._changes[-1], rcond=SMALLEST)[0]
        return np.asarray(answer - (steps + turns) @ weights)
