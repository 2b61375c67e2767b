"""Classifies messages as fresh, reordered, duplicate or of an ended session by epoch and sequence number."""

from enum import Enum
from typing import Final, NamedTuple

from passafe_protocol.messages import Header

WINDOW: Final = 2048
"""Number of the newest sequence numbers that are remembered individually."""

SESSIONS: Final = 8
"""Number of sessions of one sender that are remembered, the running one included."""

_WINDOW_BITS: Final = (1 << WINDOW) - 1
_COUNT_MAX: Final = 2**64 - 1


class Arrival(Enum):
    """Relation of a message to those of its sender that arrived before it."""

    FRESH = "fresh"
    """Newer than all messages of the sender so far."""

    REORDERED = "reordered"
    """Older than the newest message, received for the first time."""

    DUPLICATE = "duplicate"
    """Received before, or ``WINDOW`` numbers or more behind the newest, where this is not known."""

    ENDED_SESSION = "ended session"
    """Of an older epoch."""


class Session(NamedTuple):
    """Messages of one session of a sender.

    Attributes:
        epoch: Epoch of the session.
        first: Smallest sequence number.
        newest: Largest sequence number.
        received: Number of distinct messages.
    """

    epoch: int
    first: int
    newest: int
    received: int


class SequenceGuard:
    """Classifies the messages of one source on one topic.

    A larger epoch starts a new session, whatever its first number: numbers before the first message received are not
    counted as gaps, since a reader may join late. Time and memory per message are bounded.

    Attributes:
        received: Distinct messages of all sessions, FRESH or REORDERED.
        refused: DUPLICATE messages and those of an ENDED_SESSION.
    """

    def __init__(self) -> None:
        self.received = 0
        self.refused = 0
        self._epoch = -1
        self._first = 0
        self._newest = 0
        self._seen = 0  # bit i is set if number newest − i was received
        self._received_before = 0  # messages and gaps of previous sessions
        self._gaps_before = 0
        self._ended: list[Session] = []

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The newest ``SESSIONS`` sessions, oldest first."""
        return (*self._ended, self._session()) if self._epoch >= 0 else ()

    @property
    def gaps(self) -> int:
        """Sequence numbers between the first and the newest of each session that have not been received.

        At most 2⁶⁴ − 1, so that ``Health`` can carry it whatever numbers a faulty sender uses.
        """
        if self._epoch < 0:
            return 0
        span = self._newest - self._first + 1
        return min(self._gaps_before + span - (self.received - self._received_before), _COUNT_MAX)

    def classify(self, header: Header) -> Arrival:
        """Classify the message with this header and remember it."""
        if header.epoch > self._epoch:
            self._start(header)
            return Arrival.FRESH
        if header.epoch < self._epoch:
            self.refused += 1
            return Arrival.ENDED_SESSION
        ahead = header.sequence - self._newest
        if ahead > 0:
            # A jump beyond the window clears it: a shift by an arbitrary amount would cost time and memory.
            self._seen = (self._seen << ahead | 1) & _WINDOW_BITS if ahead < WINDOW else 1
            self._newest = header.sequence
            self.received += 1
            return Arrival.FRESH
        bit = 1 << -ahead if -ahead < WINDOW else 0
        if not bit or self._seen & bit:
            self.refused += 1
            return Arrival.DUPLICATE
        self._seen |= bit
        self._first = min(self._first, header.sequence)
        self.received += 1
        return Arrival.REORDERED

    def _start(self, header: Header) -> None:
        if self._epoch >= 0:
            self._ended = [*self._ended, self._session()][1 - SESSIONS :]
        self._gaps_before = self.gaps
        self._received_before = self.received
        self._epoch = header.epoch
        self._first = self._newest = header.sequence
        self._seen = 1
        self.received += 1

    def _session(self) -> Session:
        return Session(self._epoch, self._first, self._newest, self.received - self._received_before)
