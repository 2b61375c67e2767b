"""Tells fresh messages from late, repeated and foreign ones by the header's epoch and sequence number."""

from enum import Enum
from typing import Final, NamedTuple

from passafe_protocol.messages import Header

WINDOW: Final = 2048
"""How many of the newest numbers are remembered one by one."""

SESSIONS: Final = 8
"""How many sessions of one sender are remembered, the running one among them."""

_WINDOW_BITS: Final = (1 << WINDOW) - 1
_COUNT_MAX: Final = 2**64 - 1


class Arrival(Enum):
    """What a message is to the ones that came before it."""

    FRESH = "fresh"
    """Newer than all of its sender's messages so far."""

    REORDERED = "reordered"
    """Overtaken by a newer one; seen for the first time."""

    REPEATED = "repeated"
    """Seen before, or so far behind the newest (``WINDOW`` numbers or more) that nobody remembers."""

    FOREIGN = "foreign"
    """Of an older epoch: a session of the sender that has ended."""


class Session(NamedTuple):
    """Messages of one session of a sender.

    Attributes:
        epoch: Which session.
        first: Smallest number seen.
        newest: Largest number seen.
        received: Different messages seen.
    """

    epoch: int
    first: int
    newest: int
    received: int


class SequenceGuard:
    """Judges the messages of one source on one topic.

    A greater epoch starts the judgement anew, whatever its first number: numbers before the first one seen
    are no gap, since a reader may join late. Time and memory for a message do not depend on its numbers.

    Attributes:
        received: Different messages seen, in all epochs: FRESH and REORDERED ones.
        refused: REPEATED and FOREIGN ones.
    """

    def __init__(self) -> None:
        self.received = 0
        self.refused = 0
        self._epoch = -1
        self._first = 0
        self._newest = 0
        self._seen = 0  # bit i tells whether number newest − i was seen
        self._received_before = 0  # messages and gaps of the epochs before this one
        self._gaps_before = 0
        self._ended: list[Session] = []

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The newest ``SESSIONS`` sessions, oldest first."""
        return (*self._ended, self._session()) if self._epoch >= 0 else ()

    @property
    def gaps(self) -> int:
        """Numbers between the first and the newest of their epoch that were never seen so far.

        At most 2⁶⁴ − 1, so that ``Health`` can carry it whatever numbers a sender makes up.
        """
        if self._epoch < 0:
            return 0
        span = self._newest - self._first + 1
        return min(self._gaps_before + span - (self.received - self._received_before), _COUNT_MAX)

    def judge(self, header: Header) -> Arrival:
        """What the message with this header is; the guard remembers it."""
        if header.epoch > self._epoch:
            self._start(header)
            return Arrival.FRESH
        if header.epoch < self._epoch:
            self.refused += 1
            return Arrival.FOREIGN
        ahead = header.sequence - self._newest
        if ahead > 0:
            # A jump beyond the window forgets all of it; shifting by so much would cost time and memory.
            self._seen = (self._seen << ahead | 1) & _WINDOW_BITS if ahead < WINDOW else 1
            self._newest = header.sequence
            self.received += 1
            return Arrival.FRESH
        bit = 1 << -ahead if -ahead < WINDOW else 0
        if not bit or self._seen & bit:
            self.refused += 1
            return Arrival.REPEATED
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
