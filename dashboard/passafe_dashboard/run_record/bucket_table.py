"""Keep the lowest and the highest value of signals in equal buckets of time; the longer a run, the wider they are."""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]


class Extreme(NamedTuple):
    """A value of a signal and when it had it.

    Attributes:
        value: In the signal's unit.
        at_ns: Plant time, ns.
    """

    value: float
    at_ns: int


class BucketTable:
    """Signals over plant time, in at most ``most`` buckets, so that no extreme is lost.

    A bucket holds lowest and highest value of every envelope column, and the first value of every other. When a run
    outlasts the buckets, each takes in its neighbour and all are twice as wide.

    Args:
        envelopes: Columns of which lowest and highest value are kept.
        firsts: Columns of which the first value is kept, such as places along a path.
        width_ns: Width of a bucket at first, ns.
        most: Number of buckets, at least 2: those on the two sides of time 0 are never joined.
    """

    def __init__(self, envelopes: Sequence[str], firsts: Sequence[str] = (), *, width_ns: int, most: int) -> None:
        self.envelopes = tuple(envelopes)
        self.firsts = tuple(firsts)
        self.width_ns = width_ns
        self._most = most
        self._origin = 0
        self._used = 0
        self._low = np.full((len(self.envelopes), most), np.nan)
        self._high = np.full((len(self.envelopes), most), np.nan)
        self._first = np.full((len(self.firsts), most), np.nan)
        self._count = np.zeros(most, dtype=np.int64)
        self._least: list[Extreme | None] = [None] * len(self.envelopes)
        self._greatest: list[Extreme | None] = [None] * len(self.envelopes)

    def add(self, t_ns: IntArray, values: FloatArray) -> None:
        """Add samples.

        Args:
            t_ns: Plant times, ns, shape (N,).
            values: Envelope columns, then the others, shape (columns, N); NaN where a signal has no value.
        """
        if not t_ns.size:
            return
        if np.any(np.diff(t_ns) < 0):
            order = np.argsort(t_ns, kind="stable")
            t_ns, values = t_ns[order], values[:, order]
        envelopes = values[: len(self.envelopes)]
        self._make_room(int(t_ns[0]) // self.width_ns, int(t_ns[-1]) // self.width_ns)
        at, starts, counts = _groups(t_ns // self.width_ns - self._origin)
        low, high = _lowest(envelopes, starts), _highest(envelopes, starts)
        self._note_extremes(t_ns, envelopes, np.fmin.reduce(low, axis=1), np.fmax.reduce(high, axis=1))
        self._merge(at, low, high, values[:, starts], counts)

    def widen(self) -> None:
        """Make every bucket twice as wide."""
        self.width_ns *= 2
        filled = np.flatnonzero(self._count[: self._used])
        number = (filled + self._origin) // 2
        origin = self._origin // 2
        at, starts, _ = _groups(number - origin)
        low, high = _lowest(self._low[:, filled], starts), _highest(self._high[:, filled], starts)
        first = self._first[:, filled[starts]]
        count = np.add.reduceat(self._count[filled], starts) if filled.size else self._count[:0]
        for held, kept in ((self._low, low), (self._high, high), (self._first, first)):
            held.fill(np.nan)
            held[:, at] = kept
        self._count.fill(0)
        self._count[at] = count
        self._origin = origin
        self._used = int(at[-1]) + 1 if at.size else 0

    @property
    def start_ns(self) -> int:
        """Begin of the first bucket, ns."""
        return self._origin * self.width_ns

    @property
    def low(self) -> FloatArray:
        """Lowest value of each bucket, shape (envelopes, buckets); NaN where there is none."""
        return self._low[:, : self._used]

    @property
    def high(self) -> FloatArray:
        """Highest value of each bucket, likewise."""
        return self._high[:, : self._used]

    @property
    def first(self) -> FloatArray:
        """First value of each bucket, shape (firsts, buckets)."""
        return self._first[:, : self._used]

    @property
    def count(self) -> IntArray:
        """Number of samples in each bucket."""
        return self._count[: self._used]

    def least(self, column: str) -> Extreme | None:
        """Return the lowest value ever of an envelope column."""
        return self._least[self.envelopes.index(column)]

    def greatest(self, column: str) -> Extreme | None:
        """Return the highest value ever of an envelope column."""
        return self._greatest[self.envelopes.index(column)]

    def _note_extremes(self, t_ns: IntArray, envelopes: FloatArray, lowest: FloatArray, highest: FloatArray) -> None:
        for column, (low, high) in enumerate(zip(lowest.tolist(), highest.tolist(), strict=True)):
            least, greatest = self._least[column], self._greatest[column]
            if low == low and (least is None or low < least.value):  # noqa: PLR0124 - not NaN
                self._least[column] = Extreme(low, int(t_ns[np.argmax(envelopes[column] == low)]))
            if high == high and (greatest is None or high > greatest.value):  # noqa: PLR0124 - not NaN
                self._greatest[column] = Extreme(high, int(t_ns[np.argmax(envelopes[column] == high)]))

    def _make_room(self, first: int, last: int) -> None:
        """Widen buckets until those from ``first`` to ``last``, numbers at the present width, fit beside the others."""
        if not self._used:
            self._origin = first
        while max(last, self._origin + self._used - 1) - min(first, self._origin) >= self._most:
            self.widen()
            first, last = first // 2, last // 2
        ahead = self._origin - first
        if ahead > 0:
            for held in (self._low, self._high, self._first):
                held[:] = np.roll(held, ahead, axis=1)
            self._count[:] = np.roll(self._count, ahead)
            self._origin -= ahead
            self._used += ahead if self._used else 0
        self._used = max(self._used, last - self._origin + 1)

    def _merge(self, at: IntArray, low: FloatArray, high: FloatArray, pick: FloatArray, count: IntArray) -> None:
        """Add what buckets ``at`` are to hold besides what they hold."""
        self._low[:, at] = np.fmin(self._low[:, at], low)
        self._high[:, at] = np.fmax(self._high[:, at], high)
        fresh = self._count[at] == 0
        self._first[:, at[fresh]] = pick[len(self.envelopes) :, fresh]
        self._count[at] += count


def _groups(numbers: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return each of the increasing numbers once, where it begins, and how often it is there."""
    at, starts, counts = np.unique(numbers, return_index=True, return_counts=True)
    return at, starts, counts


def _lowest(values: FloatArray, starts: IntArray) -> FloatArray:
    return np.fmin.reduceat(values, starts, axis=1) if starts.size else values[:, :0]


def _highest(values: FloatArray, starts: IntArray) -> FloatArray:
    return np.fmax.reduceat(values, starts, axis=1) if starts.size else values[:, :0]
