"""Count what happens in equal stretches of time, by name; the longer a run, the wider they are."""

from collections.abc import Iterable
from typing import Final

import numpy as np

from passafe_dashboard.run_record.bucket_table import FloatArray, IntArray

NS_PER_S: Final = 1e9
LEAST_SHARE: Final = 0.2
"""Share of a stretch that a run has to cover for a rate; one message more or less would be a jump."""


class CountTable:
    """Counts by name over plant time, in at most ``most`` stretches.

    Args:
        width_ns: Width of a stretch at first, ns.
        most: Number of stretches.
    """

    def __init__(self, *, width_ns: int, most: int) -> None:
        self.width_ns = width_ns
        self._most = most
        self._counts: dict[str, dict[int, int]] = {}
        self._reach: tuple[int, int] | None = None
        self._first: int | None = None
        self._last = 0

    def add(self, name: str, t_ns: IntArray) -> None:
        """Count one for each plant time, ns, shape (N,)."""
        if not t_ns.size:
            return
        begin_ns, end_ns = self._reach or (int(t_ns.min()), int(t_ns.max()))
        self._reach = min(begin_ns, int(t_ns.min())), max(end_ns, int(t_ns.max()))
        numbers, counts = np.unique(t_ns // self.width_ns, return_counts=True)
        self._count(name, zip(numbers.tolist(), counts.tolist(), strict=True))

    def widen(self) -> None:
        """Make every stretch twice as wide."""
        self.width_ns *= 2
        for name, counts in self._counts.items():
            wider: dict[int, int] = {}
            for number, count in counts.items():
                wider[number // 2] = wider.get(number // 2, 0) + count
            self._counts[name] = wider
        if self._first is not None:
            self._first, self._last = self._first // 2, self._last // 2

    @property
    def names(self) -> tuple[str, ...]:
        """Names that were counted, in the order in which they came."""
        return tuple(self._counts)

    @property
    def start_ns(self) -> int:
        """Begin of the first stretch, ns."""
        return (self._first or 0) * self.width_ns

    def counts(self, name: str) -> FloatArray:
        """Return the count of each stretch, shape (stretches,)."""
        if self._first is None:
            return np.zeros(0)
        row = np.zeros(self._last - self._first + 1)
        for number, count in self._counts.get(name, {}).items():
            row[number - self._first] = count
        return row

    def per_s(self, name: str) -> FloatArray:
        """Return the count of each stretch by its length within the run, 1/s; NaN where that is next to nothing."""
        counts = self.counts(name)
        if self._reach is None:
            return counts
        starts = self.start_ns + np.arange(counts.size) * self.width_ns
        begin_ns, end_ns = self._reach
        within = np.minimum(starts + self.width_ns, end_ns) - np.maximum(starts, begin_ns)
        return np.where(within > LEAST_SHARE * self.width_ns, counts * NS_PER_S / np.maximum(within, 1), np.nan)

    def _count(self, name: str, found: Iterable[tuple[int, int]]) -> None:
        counts = self._counts.setdefault(name, {})
        for number, count in found:
            counts[number] = counts.get(number, 0) + count
            self._first = number if self._first is None else min(self._first, number)
            self._last = max(self._last, number)
        while self._first is not None and self._last - self._first >= self._most:
            self.widen()
