"""Scheduled outages of a link."""

from typing import Final

from passafe_protocol.link_settings import Span

_NS_PER_S: Final = 1e9


class Outages:
    """Scheduled outages; time zero is the first message.

    Args:
        spans_s: Start and end of each outage, s; the end is excluded.
    """

    def __init__(self, spans_s: tuple[Span, ...]) -> None:
        self._spans_ns = [(round(start_s * _NS_PER_S), round(end_s * _NS_PER_S)) for start_s, end_s in spans_s]
        self._zero_ns: int | None = None

    def cover(self, now_ns: int) -> bool:
        """Check whether ``now_ns`` lies in an outage."""
        if self._zero_ns is None:
            self._zero_ns = now_ns
        since_ns = now_ns - self._zero_ns
        return any(start_ns <= since_ns < end_ns for start_ns, end_ns in self._spans_ns)
