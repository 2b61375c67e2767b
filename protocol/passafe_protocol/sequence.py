"""Decides which session of a sender is the current one, and classifies messages by session and sequence number."""

from typing import Final

from passafe_protocol.messages import Header
from passafe_protocol.sequence_window import (
    USUAL,
    Arrival,
    MissingRange,
    SequenceWindow,
    Session,
    WindowSize,
    missing_of,
)

SESSIONS: Final = 8
"""Number of sessions of one sender that are remembered, the current one included."""

COUNT_MAX: Final = 2**64 - 1


class SequenceGuard:
    """Classifies the messages of one source on one topic, of which one session at a time is current.

    An epoch identifies a session and does not order sessions: neither a wall clock nor a stranger decides which one is
    the newest. The current session keeps its place for as long as it is received: until ``hold_ns`` after its last
    accepted message; then the next message of another session takes it. Hence:

    - A message of a stranger, whatever its epoch, changes nothing while the rightful sender is received; sent in
      its silence, it delays the rightful sender by ``hold_ns`` at most once the stranger is silent.
    - A restarted sender is accepted within ``hold_ns``, whatever its clock shows.
    - An ended session does not come back: what can still arrive of it are copies, which its remembered numbers refuse.
      A session that was displaced and sends numbers larger than all that were received of it has not ended.

    A number beyond what the session can have come to (``SequenceWindow.newest_possible``) is refused: one forged number
    costs the rightful sender at most a burst of its own. Time and memory per message are bounded; only sessions that
    were current are remembered, so a flood of forged ones displaces none.

    Args:
        hold_ns: Silence after which another session may become current, ns.
        size: How much of a session is remembered and believed.

    Attributes:
        term: Number of times that the place has changed hands; orders the sessions for a node behind a link.
        received: Distinct messages of all sessions, FRESH or REORDERED.
        refused: All other messages.
    """

    def __init__(self, hold_ns: int, size: WindowSize = USUAL) -> None:
        self.term = 0
        self.received = 0
        self.refused = 0
        self._hold_ns = hold_ns
        self._size = size
        self._epoch = -1
        self._current: SequenceWindow | None = None
        self._windows: dict[int, SequenceWindow] = {}  # of sessions that were current, by epoch; the current one last
        self._gaps_forgotten = 0

    @property
    def epoch(self) -> int:
        """Epoch of the current session; −1 before the first message."""
        return self._epoch

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The ``SESSIONS`` sessions that were current last; the current one comes last."""
        return tuple(Session(epoch, w.first, w.newest, w.received) for epoch, w in self._windows.items())

    @property
    def gaps(self) -> int:
        """Sequence numbers between the first and the newest of each session that have not been received.

        At most 2⁶⁴ − 1, so that ``Health`` can carry it whatever numbers a faulty sender uses.
        """
        return min(self._gaps_forgotten + sum(window.gaps for window in self._windows.values()), COUNT_MAX)

    def missing(self) -> list[MissingRange]:
        """Return the numbers of the current session that have not been received, as far as the window reaches back."""
        return [] if self._current is None else missing_of({self._epoch: self._current})

    def newest_possible(self, now_ns: int) -> int:
        """Return the largest number that the current session can have come to; −1 before the first message.

        Args:
            now_ns: Reader's monotonic time, ns.
        """
        return -1 if self._current is None else self._current.newest_possible(now_ns)

    def classify(self, header: Header, now_ns: int) -> Arrival:
        """Classify the message with this header and remember it.

        Args:
            header: Its header.
            now_ns: Reader's monotonic time, ns; non-decreasing.
        """
        current = self._current
        if current is not None and header.epoch == self._epoch:
            arrival = current.classify(header.sequence, now_ns)
        elif current is not None and now_ns - current.accepted_ns < self._hold_ns:
            arrival = Arrival.FOREIGN
        else:
            arrival = self._change(header, now_ns)
        if arrival is Arrival.FRESH or arrival is Arrival.REORDERED:
            self.received += 1
        else:
            self.refused += 1
        return arrival

    def _change(self, header: Header, now_ns: int) -> Arrival:
        """Let another session have the place, unless it ended."""
        window = self._windows.get(header.epoch)
        if window is None:
            window = SequenceWindow(header.sequence, now_ns, self._size)
            if len(self._windows) == SESSIONS:
                self._gaps_forgotten += self._windows.pop(next(iter(self._windows))).gaps
        elif header.sequence <= window.newest:
            return Arrival.FOREIGN
        elif window.classify(header.sequence, now_ns) is Arrival.FAR_AHEAD:
            return Arrival.FAR_AHEAD
        else:
            del self._windows[header.epoch]
        self.term += self._current is not None
        self._windows[header.epoch] = self._current = window
        self._epoch = header.epoch
        return Arrival.FRESH
