"""Check that a log shows one robot: plants that ran one after the other, never two at once."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

from passafe_protocol.messages import UNKNOWN_CLOCK, Header, PlantState

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.trajectory import NS_PER_S


def two_plants(states: Sequence[LoggedMessage[PlantState]]) -> str:
    """Return in words that two plants ran at once, so that nobody can tell of which the log speaks; empty if not.

    Args:
        states: All plant states of a log.
    """
    headers = [state.header for state in states]
    clocks = {header.clock_id for header in headers}
    is_one_clock = len(clocks) == 1 and UNKNOWN_CLOCK not in clocks
    both_s = _overlap_ns((header.epoch, _sent_ns(header, is_one_clock=is_one_clock)) for header in headers) / NS_PER_S
    return f"states of two plants came at once, for {both_s:.3g} s" if both_s > 0 else ""


def _sent_ns(header: Header, *, is_one_clock: bool) -> int:
    """Return a time that headers share: monotonic if they come from one machine, else the wall clock."""
    return header.sent_ns if is_one_clock else header.wall_ns


def _overlap_ns(sent: Iterable[tuple[int, int]]) -> int:
    """Return for how long sessions overlap at the most, ns, from the session and the time of every message."""
    spans: dict[int, tuple[int, int]] = {}
    for epoch, at_ns in sent:
        first_ns, last_ns = spans.get(epoch, (at_ns, at_ns))
        spans[epoch] = min(first_ns, at_ns), max(last_ns, at_ns)
    longest_ns, end_ns = 0, None
    for (_, last_ns), (other_ns, other_last_ns) in pairwise(sorted(spans.values())):
        end_ns = last_ns if end_ns is None else max(end_ns, last_ns)
        longest_ns = max(longest_ns, min(end_ns, other_last_ns) - other_ns)
    return longest_ns
