"""Decimate signals so that every dip stays visible: one row a bin, with each column's lowest, highest or last value.

A chart of every thirtieth sample hides a barrier that was negative for 5 ms; here the worst value of any stretch of
time survives.
"""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum
from itertools import pairwise
from math import inf
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

NS_PER_S: Final = 1_000_000_000


class Keep(Enum):
    """Value of a column that represents a bin."""

    LAST = "last"
    LOWEST = "lowest"
    HIGHEST = "highest"


class SeriesRow(NamedTuple):
    """One bin.

    Attributes:
        number: Counts rows from 0, without gaps.
        start_s: Begin of the bin on the time axis.
        end_s: Its end.
        values: One a column; ``None`` throughout in the row that marks an interruption.
    """

    number: int
    start_s: float
    end_s: float
    values: tuple[float | None, ...]


class RowBatch(NamedTuple):
    """Rows that a reader had not read.

    Attributes:
        rows: In order.
        cursor: Cursor for the next read.
        lost: Rows that were overwritten before they were read.
    """

    rows: tuple[SeriesRow, ...]
    cursor: int
    lost: int


class WorstSample(NamedTuple):
    """Lowest value of a column so far and its place on the time axis."""

    value: float
    at_s: float


class DecimatedSeries:
    """A bounded ring of rows, fed sample by sample and read by any number of readers, each with a cursor.

    A slow reader loses the oldest rows, and learns how many; it delays nobody.

    Attributes:
        columns: Names, in the order of a row's values.

    Args:
        columns: Value to keep of each column.
        bin_ns: Width of a bin, ns.
        capacity: Rows held.
        gap_bins: A time step longer than this many bins is an interruption, marked by an empty row.
    """

    def __init__(self, columns: Mapping[str, Keep], *, bin_ns: int, capacity: int, gap_bins: int = 8) -> None:
        self.columns = tuple(columns)
        self._bin_ns = bin_ns
        self._gap_bins = gap_bins
        kept = tuple(enumerate(columns.items()))
        self._lowest = tuple(i for i, (_, keep) in kept if keep is Keep.LOWEST)
        self._highest = tuple(i for i, (_, keep) in kept if keep is Keep.HIGHEST)
        self._rows: deque[SeriesRow] = deque(maxlen=capacity)
        self._made = 0
        self._bin: int | None = None
        self._open: list[float] = []
        self._worst = [inf] * len(self.columns)
        self._worst_ns = [0] * len(self.columns)

    @property
    def first(self) -> int:
        """Cursor of a reader that wants every row held."""
        return self._made - len(self._rows)

    @property
    def worst(self) -> dict[str, WorstSample]:
        """Lowest sample ever of each column whose lowest value is kept, rows that are gone included."""
        if self._bin is None:
            return {}
        return {self.columns[i]: WorstSample(self._worst[i], self._worst_ns[i] / NS_PER_S) for i in self._lowest}

    def add(self, time_ns: int, values: Sequence[float]) -> None:
        """Add one sample.

        A sample a little older than the open bin counts into that bin; one much older begins a bin of its own
        after an interruption. Either way its minimum is kept.

        Args:
            time_ns: Its place on the time axis, ns.
            values: One a column, finite.
        """
        number = time_ns // self._bin_ns
        if self._bin is None:
            self._begin(number, time_ns, values)
            return
        ahead = number - self._bin
        if ahead > 0 or ahead < -self._gap_bins:
            self._append(self._bin, self._bin + 1, tuple(self._open))
            if abs(ahead) > self._gap_bins:
                self._append(self._bin + 1, max(self._bin + 2, number), (None,) * len(self.columns))
            self._begin(number, time_ns, values)
            return
        before, self._open = self._open, list(values)
        for i in self._lowest:
            if before[i] < values[i]:
                self._open[i] = before[i]
            elif values[i] < self._worst[i]:
                self._worst[i], self._worst_ns[i] = values[i], time_ns
        for i in self._highest:
            if before[i] > values[i]:
                self._open[i] = before[i]

    def since(self, cursor: int) -> RowBatch:
        """Return the rows from ``cursor`` on; the bin still open is not among them."""
        first = self.first
        start = max(cursor, first)
        rows = tuple(self._rows[i - first] for i in range(start, self._made))
        return RowBatch(rows, self._made, max(0, first - cursor))

    def _begin(self, number: int, time_ns: int, values: Sequence[float]) -> None:
        self._bin, self._open = number, list(values)
        for i in self._lowest:
            if values[i] < self._worst[i]:
                self._worst[i], self._worst_ns[i] = values[i], time_ns

    def _append(self, first_bin: int, end_bin: int, values: tuple[float | None, ...]) -> None:
        start_s, end_s = first_bin * self._bin_ns / NS_PER_S, end_bin * self._bin_ns / NS_PER_S
        self._rows.append(SeriesRow(self._made, start_s, end_s, values))
        self._made += 1


def kept_samples(columns: Iterable[NDArray[np.float64]], *, bins: int) -> NDArray[np.intp]:
    """Return the indices of samples that draw the same picture as all: lowest and highest of each bin and column.

    Args:
        columns: Columns of one length k, finite.
        bins: Number of equal bins; with k ≤ 2·bins every sample is kept.

    Returns:
        Increasing indices, the first and the last sample among them.
    """
    kept: list[NDArray[np.intp]] = []
    for column in columns:
        count = len(column)
        if count <= 2 * bins:
            return np.arange(count)
        edges = np.linspace(0, count, bins + 1).astype(np.intp)
        spans = list(pairwise(edges))
        kept.append(np.array([a + np.argmin(column[a:b]) for a, b in spans], dtype=np.intp))
        kept.append(np.array([a + np.argmax(column[a:b]) for a, b in spans], dtype=np.intp))
        kept.append(np.array([0, count - 1], dtype=np.intp))
    return np.unique(np.concatenate(kept)) if kept else np.empty(0, dtype=np.intp)
