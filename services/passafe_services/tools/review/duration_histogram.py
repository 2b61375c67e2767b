"""Counts of durations, from which percentiles follow: exact for a run of minutes, to 0.1 % for one of any length."""

from typing import Final

import numpy as np

from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.plant_evaluator import FloatArray

MOST_EXACT: Final = 1 << 19
"""Different durations that are counted exactly; of more, those within 0.1 % of one another are counted as one."""

_BITS_LEFT_OUT: Final = 52 - 10
"""Bits of a double's 52 of mantissa that a coarse count drops: it keeps 10, so values differ by 2⁻¹⁰ at most."""


class DurationHistogram:
    """Counts of durations in whole nanoseconds, of bounded size."""

    def __init__(self) -> None:
        self._values: IntArray = np.zeros(0, dtype=np.int64)
        self._counts: IntArray = np.zeros(0, dtype=np.int64)
        self.largest_ns: int | None = None

    @property
    def total(self) -> int:
        """Number of durations."""
        return int(self._counts.sum())

    def add(self, durations_ns: IntArray) -> None:
        """Count durations, ns."""
        if not durations_ns.size:
            return
        largest_ns = int(durations_ns.max())
        self.largest_ns = largest_ns if self.largest_ns is None else max(self.largest_ns, largest_ns)
        values, counts = np.unique(durations_ns, return_counts=True)
        self._merge(values, counts)
        if self._values.size > MOST_EXACT:
            values, counts = _coarse(self._values), self._counts
            self._values, self._counts = self._values[:0], self._counts[:0]
            self._merge(values, counts)

    def percentiles(self, *which: float) -> tuple[float, ...]:
        """Return percentiles of at least one duration, interpolated linearly as NumPy does, ns."""
        ends = np.cumsum(self._counts)
        found = []
        for percent in which:
            place = (self.total - 1) * (percent / 100)
            below = int(np.searchsorted(ends, int(place), side="right"))
            above = int(np.searchsorted(ends, min(int(place) + 1, self.total - 1), side="right"))
            low, high = float(self._values[below]), float(self._values[above])
            share = place - int(place)
            # The two sides of NumPy's rule, so that the same durations give the same number.
            found.append(low + (high - low) * share if share < 0.5 else high - (high - low) * (1 - share))  # noqa: PLR2004 - half
        return tuple(found)

    def _merge(self, values: IntArray, counts: IntArray) -> None:
        both = np.concatenate((self._values, values))
        self._values, where = np.unique(both, return_inverse=True)
        weights = np.concatenate((self._counts, counts))
        self._counts = np.bincount(where, weights=weights, minlength=self._values.size).astype(np.int64)


def _coarse(values_ns: IntArray) -> IntArray:
    """Return each duration rounded towards zero to eleven binary digits."""
    as_float: FloatArray = values_ns.astype(np.float64)
    bits = as_float.view(np.int64) >> _BITS_LEFT_OUT << _BITS_LEFT_OUT
    rounded: IntArray = bits.view(np.float64).astype(np.int64)
    return rounded
