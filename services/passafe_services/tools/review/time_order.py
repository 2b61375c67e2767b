"""Rows put in order of plant time while they come, within a bounded time."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray

PATIENCE_NS: Final = 2_000_000_000
"""Plant time by which a decision may come after one for a later time."""

MOST_WAITING: Final = 1 << 17
"""Rows that wait at the most: two minutes at 1 kHz."""


class TimeOrder:
    """Rows of numbers, each at a plant time, in order of that time; equal times in the order in which they came.

    Args:
        width: Numbers of a row.

    Attributes:
        out_of_order: Rows that came too late to be put in order, and were put last.
    """

    def __init__(self, width: int) -> None:
        self._at_ns: IntArray = np.zeros(0, dtype=np.int64)
        self._rows: FloatArray = np.zeros((width, 0))
        self._released_ns: int | None = None
        self.out_of_order = 0

    def take(self, at_ns: IntArray, rows: FloatArray) -> tuple[IntArray, FloatArray]:
        """Take rows, shape (width, N), and return those that are in order now."""
        if not at_ns.size:
            return self._at_ns[:0], self._rows[:, :0]
        until_ns = int(at_ns[-1]) - PATIENCE_NS
        self._add(at_ns, rows)
        return self._release(max(int(np.searchsorted(self._at_ns, until_ns)), self._at_ns.size - MOST_WAITING))

    def finish(self) -> tuple[IntArray, FloatArray]:
        """Return what is left."""
        return self._release(self._at_ns.size)

    def _add(self, at_ns: IntArray, rows: FloatArray) -> None:
        if self._released_ns is not None:
            late: NDArray[np.bool_] = at_ns < self._released_ns
            self.out_of_order += int(late.sum())
        both = np.concatenate((self._at_ns, at_ns))
        all_rows = np.concatenate((self._rows, rows), axis=1)
        if (np.diff(both) < 0).any():
            order = np.argsort(both, kind="stable")
            both, all_rows = both[order], all_rows[:, order]
        self._at_ns, self._rows = both, all_rows

    def _release(self, count: int) -> tuple[IntArray, FloatArray]:
        at_ns, rows = self._at_ns[:count], self._rows[:, :count]
        self._at_ns, self._rows = self._at_ns[count:], self._rows[:, count:]
        if at_ns.size:
            self._released_ns = int(at_ns[-1])
        return at_ns, rows
