"""Reads the topics of a node within a share of its period, whatever a stranger sends."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Final, Protocol

from passafe_services.loop.inlet import Inlet

DRAIN_SHARE: Final = 0.1
"""Share of a period in which messages are taken from the bus."""

READ_SHARE: Final = 0.25
"""Share of a period in which messages are decoded; the rest of it is for the node."""

AT_ONCE: Final = 16
"""Messages taken from one topic before the others have their turn."""


class PayloadReader(Protocol):
    """Reader of a topic, such as ``TopicReader``."""

    def drain(self, at_most: int) -> list[bytes]:
        """Return the oldest payloads that were not returned yet, so many at most."""
        ...


class BoundedReading:
    """Messages of several topics that wait to be decoded, of each at most as many as its queue holds.

    The topics take turns, so that a flood on one of them delays the others by one message each. What is not decoded in
    time waits for the next step; when a queue is full, its oldest message is dropped, as in the reader's own. Taking a
    message from the bus takes microseconds too: with full readers on every topic, more than a period.

    Args:
        readers: Inlet and reader of each topic.
    """

    def __init__(self, readers: Sequence[tuple[Inlet, PayloadReader]]) -> None:
        self._sources = tuple((inlet, reader, deque[bytes](maxlen=inlet.topic.queue)) for inlet, reader in readers)

    def drain(self, end_ns: int, monotonic_ns: Callable[[], int]) -> None:
        """Move what was received since the last call to the messages that wait.

        Args:
            end_ns: Monotonic time after which no further round begins, ns; the rest stays in the readers.
            monotonic_ns: The clock.
        """
        sources = [(reader, waiting) for _, reader, waiting in self._sources]
        while sources:
            arrived = [(reader, waiting, reader.drain(AT_ONCE)) for reader, waiting in sources]
            for _, waiting, payloads in arrived:
                waiting.extend(payloads)
            if monotonic_ns() >= end_ns:
                return
            sources = [(reader, waiting) for reader, waiting, payloads in arrived if len(payloads) == AT_ONCE]

    def messages(self, end_ns: int, monotonic_ns: Callable[[], int]) -> Iterator[tuple[Inlet, bytes]]:
        """Yield inlet and payload of the waiting messages, of each topic the oldest first, until none is left.

        One message of each topic is yielded even if the time is over, so that no topic is shut out for good.

        Args:
            end_ns: Monotonic time after which no further round begins, ns.
            monotonic_ns: The clock.
        """
        waiting = [(inlet, queue) for inlet, _, queue in self._sources if queue]
        while waiting:
            for inlet, queue in waiting:
                yield inlet, queue.popleft()
            if monotonic_ns() >= end_ns:
                return
            waiting = [each for each in waiting if each[1]]
