"""Check that a log shows one robot: plants that ran one after the other, never two at once."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from passafe_protocol.messages import UNKNOWN_CLOCK, PlantState

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.trajectory import NS_PER_S


def two_plants(states: Sequence[LoggedMessage[PlantState]]) -> str:
    """Return in words that two plants ran at once, so that nobody can tell of which the log speaks; empty if not.

    Args:
        states: All plant states of a log.
    """
    record = PlantRecord()
    for header, _ in states:
        record.add(header.epoch, header.clock_id, *[np.array([at_ns]) for at_ns in (header.sent_ns, header.wall_ns)])
    return record.in_words()


class PlantRecord:
    """Sessions of the plant and when each sent its states."""

    def __init__(self) -> None:
        self._clocks: set[int] = set()
        self._sent: dict[int, tuple[int, int]] = {}
        self._walls: dict[int, tuple[int, int]] = {}

    def add(self, epoch: int, clock_id: int, sent_ns: IntArray, wall_ns: IntArray) -> None:
        """Add states of a session by the times at which they were sent, monotonic and wall, ns; at least one."""
        self._clocks.add(clock_id)
        for spans, times_ns in ((self._sent, sent_ns), (self._walls, wall_ns)):
            first_ns, last_ns = spans.get(epoch, (int(times_ns[0]), int(times_ns[0])))
            spans[epoch] = min(first_ns, int(times_ns.min())), max(last_ns, int(times_ns.max()))

    @property
    def spans(self) -> Mapping[int, tuple[int, int]]:
        """First and last time of each session, ns: monotonic if they come from one machine, else of the wall clock."""
        is_one_clock = len(self._clocks) == 1 and UNKNOWN_CLOCK not in self._clocks
        return self._sent if is_one_clock else self._walls

    def in_words(self) -> str:
        """Return in words that two plants ran at once; empty if not."""
        both_s = _overlap_ns(self.spans.values()) / NS_PER_S
        return f"states of two plants came at once, for {both_s:.3g} s" if both_s > 0 else ""


def _overlap_ns(spans: Iterable[tuple[int, int]]) -> int:
    """Return for how long sessions overlap at the most, ns, from the first and last time of each."""
    longest_ns, end_ns = 0, None
    for (_, last_ns), (other_ns, other_last_ns) in pairwise(sorted(spans)):
        end_ns = last_ns if end_ns is None else max(end_ns, last_ns)
        longest_ns = max(longest_ns, min(end_ns, other_last_ns) - other_ns)
    return longest_ns
