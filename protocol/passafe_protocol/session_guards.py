"""Classifies the messages of a source whose sessions may send side by side."""

from typing import Final

from passafe_protocol.messages import Header
from passafe_protocol.sequence import COUNT_MAX, SESSIONS, SequenceGuard
from passafe_protocol.sequence_window import (
    USUAL,
    Arrival,
    MissingRange,
    SequenceWindow,
    Session,
    WindowSize,
    missing_of,
)
from passafe_protocol.topics import Topic

MIN_HOLD_S: Final = 0.25
"""Least silence after which another session may take the place: 2.5 periods of the slowest scenario, well under 1 s."""

HOLD_PERIODS: Final = 1.5
"""The same in periods of a topic with a slower rate: a sender in time is received once in each."""


class SessionGuards:
    """Classifies the messages of one source on a topic that admits any session (``Topic.any_session``).

    No session ends another, so that neither an older nor a newer one locks it out: the node decides which counts. The
    ``SESSIONS`` received from last are remembered; an older one begins anew.

    Args:
        size: How much of a session is remembered and believed.

    Attributes:
        term: Always 0: the sessions have no order.
        refused: DUPLICATE and FAR_AHEAD messages.
    """

    term = 0

    def __init__(self, size: WindowSize = USUAL) -> None:
        self.refused = 0
        self._size = size
        self._windows: dict[int, SequenceWindow] = {}  # the one received from last comes last
        self._received = self._gaps = 0  # of sessions that are forgotten

    @property
    def received(self) -> int:
        """Distinct messages of all sessions."""
        return self._received + sum(window.received for window in self._windows.values())

    @property
    def gaps(self) -> int:
        """Sequence numbers never received, of each session between its first and its newest; at most 2⁶⁴ − 1."""
        return min(self._gaps + sum(window.gaps for window in self._windows.values()), COUNT_MAX)

    @property
    def epoch(self) -> int:
        """Epoch of the session received from last; −1 before the first message."""
        return next(reversed(self._windows), -1)

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The remembered sessions; the one received from last comes last."""
        return tuple(Session(epoch, w.first, w.newest, w.received) for epoch, w in self._windows.items())

    def missing(self) -> list[MissingRange]:
        """Return the numbers of remembered sessions that have not been received, as far as the window reaches back."""
        return missing_of(self._windows)

    def newest_possible(self, now_ns: int) -> int:
        """Return the largest number that the session received from last can have come to; −1 before the first message.

        Args:
            now_ns: Reader's monotonic time, ns.
        """
        return self._windows[self.epoch].newest_possible(now_ns) if self._windows else -1

    def classify(self, header: Header, now_ns: int) -> Arrival:
        """Classify the message with this header and remember it.

        Args:
            header: Its header.
            now_ns: Reader's monotonic time, ns; non-decreasing.
        """
        windows = self._windows
        window = windows.pop(header.epoch, None)
        if window is None:
            if len(windows) == SESSIONS:
                self._forget(windows.pop(next(iter(windows))))
            windows[header.epoch] = SequenceWindow(header.sequence, now_ns, self._size)
            return Arrival.FRESH
        windows[header.epoch] = window
        arrival = window.classify(header.sequence, now_ns)
        self.refused += arrival is Arrival.DUPLICATE or arrival is Arrival.FAR_AHEAD
        return arrival

    def _forget(self, window: SequenceWindow) -> None:
        self._received += window.received
        self._gaps += window.gaps


def hold_ns(topic: Topic) -> int:
    """Return the silence of a topic's current session after which another one may become current, ns."""
    period_s = 1.0 / topic.rate_hz if topic.rate_hz else 0.0
    return round(1e9 * max(MIN_HOLD_S, HOLD_PERIODS * period_s))


def guard_of(topic: Topic, size: WindowSize = USUAL) -> SequenceGuard | SessionGuards:
    """Return the guard for one source of a topic.

    Args:
        topic: The topic.
        size: How much of a session is remembered and believed.
    """
    return SessionGuards(size) if topic.any_session else SequenceGuard(hold_ns(topic), size)
