"""Fallbacks of a run: ticks in which a hard row was missed, or may have been, counted as they come."""

from collections import Counter
from collections.abc import Iterable
from typing import Final, Self

import numpy as np
from passafe_protocol.messages import FilterStatus

from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.trajectory import NS_PER_S

FALLBACKS: Final = tuple(status for status in FilterStatus if status.is_fallback and status is not FilterStatus.STALE)
"""Statuses of a tick in a fallback. A stale command fades under the same rows; see ``DriveRecord`` for it."""


_NUMBERS: Final = tuple(status.value for status in FALLBACKS)
_OF_NUMBER: Final = {status.value: status for status in FilterStatus}


class FallbackRecord:
    """Counts of the ticks in a fallback, the first of them, and the longest stretch of them.

    Args:
        period_ns: How long a tick lasts, ns.
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._ticks = 0
        self._counts: Counter[FilterStatus] = Counter()
        self._first_ns: int | None = None
        self._begun_ns: int | None = None
        self._longest_ns = 0

    @classmethod
    def of(cls, ticks: Iterable[tuple[FilterStatus, int]], period_ns: int) -> Self:
        """Return the record of ticks in order, each given by its status and plant time, ns."""
        record = cls(period_ns)
        for status, at_ns in ticks:
            record.add(status, at_ns)
        return record

    def add(self, status: FilterStatus, at_ns: int) -> None:
        """Add a tick that takes effect at a plant time, ns."""
        self._ticks += 1
        if status not in FALLBACKS:
            self._begun_ns = None
            return
        self._counts[status] += 1
        if self._first_ns is None:
            self._first_ns = at_ns
        if self._begun_ns is None or at_ns < self._begun_ns:  # a restarted plant begins at 0 again
            self._begun_ns = at_ns
        self._longest_ns = max(self._longest_ns, at_ns + self._period_ns - self._begun_ns)

    def add_all(self, status: IntArray, at_ns: IntArray) -> None:
        """Add ticks in order, by numbers of their status and the plant times, ns, at which they take effect."""
        (fallbacks,) = np.nonzero(np.isin(status, _NUMBERS))
        if not fallbacks.size:
            self._ticks += at_ns.size
            self._begun_ns = None if at_ns.size else self._begun_ns
            return
        for number, tick_ns in zip(status.tolist(), at_ns.tolist(), strict=True):
            self.add(_OF_NUMBER[number], tick_ns)

    def property(self) -> Property:
        """Return the property that no tick was in a fallback."""
        count = self._counts.total()
        return Property(
            holds=count == 0 if self._ticks else None,
            required=True,
            worst=float(count) if self._ticks else None,
            at_s=None if self._first_ns is None else self._first_ns / NS_PER_S,
            requirement=f"ticks in a fallback ({', '.join(status.name for status in FALLBACKS)}) = 0",
            allowed="= 0",
            note=self._note(count),
        )

    def _note(self, count: int) -> str:
        if self._first_ns is None:
            return ""
        of_each = ", ".join(f"{status.name} {number}" for status, number in self._counts.items())
        return (
            f"in a fallback in {count} of {self._ticks} ticks ({count / self._ticks:.2%}: {of_each}), "
            f"first at {self._first_ns / NS_PER_S:.3f} s, longest stretch {self._longest_ns / NS_PER_S:.3f} s"
        )
