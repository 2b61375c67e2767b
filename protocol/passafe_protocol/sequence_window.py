"""Numbers of one session: which were received, and which are too far ahead of the others to be its own."""

import re
from collections.abc import Mapping
from enum import Enum
from typing import Final, NamedTuple

WINDOW: Final = 2048
"""Number of the newest sequence numbers that are remembered individually, where nobody asks for missed ones."""

MAX_RATE_HZ: Final = 4000
"""Numbers that a session can use up in a second in the long run: twice the largest rate of a scenario."""

BURST: Final = 64
"""Numbers that it can use up at once: a filter decides at most so many inputs in one step."""


class WindowSize(NamedTuple):
    """Limits of what is remembered and believed of a session.

    Attributes:
        remembered: Number of the newest sequence numbers that are remembered individually.
        burst: Numbers that a session can use up at once; more for a reader that is given what was held up.
    """

    remembered: int = WINDOW
    burst: int = BURST


USUAL: Final = WindowSize()


_NS_PER_S: Final = 1_000_000_000


class Arrival(Enum):
    """Relation of a message to those of its sender that arrived before it."""

    FRESH = "fresh"
    """Newer than all messages of its session so far."""

    REORDERED = "reordered"
    """Older than the newest message, received for the first time."""

    DUPLICATE = "duplicate"
    """Received before, or so many numbers behind the newest that this is not known."""

    FOREIGN = "foreign"
    """Of another session than the current one, which has not been silent for long enough."""

    FAR_AHEAD = "far ahead"
    """Numbered further ahead of the newest message than its session can have come since."""


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


class MissingRange(NamedTuple):
    """Numbers of one session of a sender, none of which was received.

    Attributes:
        epoch: Epoch of the session.
        first: The smallest.
        last: The largest.
    """

    epoch: int
    first: int
    last: int


class SequenceWindow:
    """Sequence numbers of one session, in bounded time and memory.

    Numbers before the first message are no gaps: a reader may join late. A first message to which the second does not
    fit counts for nothing: if it was forged, the rightful sender goes on as if it had not come.

    Attributes:
        first: Smallest number received.
        newest: Largest number received.
        received: Distinct messages received.
        accepted_ns: Reader's monotonic time of the last message accepted, ns.
    """

    __slots__ = ("_burst", "_mask", "_seen", "_size", "accepted_ns", "first", "newest", "received")

    def __init__(self, sequence: int, now_ns: int, size: WindowSize = USUAL) -> None:
        """Begin with the first message of a session.

        Args:
            sequence: Its number.
            now_ns: Reader's monotonic time, ns.
            size: How much is remembered and believed.
        """
        self._size, self._burst = size
        self._mask = (1 << self._size) - 1
        self.first = sequence
        self.newest = sequence
        self.received = 1
        self.accepted_ns = now_ns
        self._seen = 1  # bit i is set if number newest − i was received

    @property
    def gaps(self) -> int:
        """Numbers between the first and the newest that have not been received."""
        return self.newest - self.first + 1 - self.received

    def missing(self) -> list[tuple[int, int]]:
        """Return the first and the last of every range of numbers that were not received, as far as it is known."""
        span = min(self.newest - self.first + 1, self._size)
        oldest = self.newest - span + 1
        seen = f"{self._seen & (1 << span) - 1:0{span}b}"  # of the oldest number first
        return [(oldest + found.start(), oldest + found.end() - 1) for found in re.finditer("0+", seen)]

    def newest_possible(self, now_ns: int) -> int:
        """Return the largest number that the session can have come to: newest + burst + ``MAX_RATE_HZ`` · silence.

        Args:
            now_ns: Reader's monotonic time, ns.
        """
        return self.newest + self._burst + (now_ns - self.accepted_ns) * MAX_RATE_HZ // _NS_PER_S

    def classify(self, sequence: int, now_ns: int) -> Arrival:
        """Classify the message with this number, and remember it unless it is refused.

        Args:
            sequence: Its number.
            now_ns: Reader's monotonic time, ns.
        """
        ahead = sequence - self.newest
        is_far = sequence > self.newest_possible(now_ns)
        if self.received == 1 and (is_far or ahead <= -self._size):
            self.first = self.newest = sequence
            self.accepted_ns = now_ns
            return Arrival.FRESH
        if is_far:
            return Arrival.FAR_AHEAD
        if ahead > 0:
            # A jump beyond the window clears it: a shift by an arbitrary amount would cost time and memory.
            self._seen = (self._seen << ahead | 1) & self._mask if ahead < self._size else 1
            self.newest = sequence
            self.received += 1
            self.accepted_ns = now_ns
            return Arrival.FRESH
        bit = 1 << -ahead if -ahead < self._size else 0
        if not bit or self._seen & bit:
            return Arrival.DUPLICATE
        self._seen |= bit
        self.first = min(self.first, sequence)
        self.received += 1
        self.accepted_ns = now_ns
        return Arrival.REORDERED


def missing_of(windows: Mapping[int, SequenceWindow]) -> list[MissingRange]:
    """Return what is missing of sessions, given by epoch."""
    return [
        MissingRange(epoch, *found) for epoch, window in windows.items() if window.gaps for found in window.missing()
    ]
