"""Reader of every message of every topic, and questions to the caches of their publishers."""

from collections.abc import Callable
from itertools import islice
from typing import Final

import zenoh
from zenoh import ext, handlers

from passafe_services.loop.access import CACHE

CACHED_SAMPLES: Final = 16_384
"""Messages that a publisher caches for the recorder: 16 s at 1 kHz, longer than a restart of the router takes."""

RECORDING_QUEUE: Final = 16_384
"""Capacity of a recording reader. A full one blocks the session; the publishers' caches then fill the gap."""

CACHE_TIMEOUT_S: Final = 2.0
"""Longest time that a question to the caches may take, s."""


class CacheAnswer:
    """Answer of the caches of one key's publishers, while it comes in.

    Attributes:
        has_ended: Whether all of it was drained.
    """

    def __init__(self, replies: handlers.Handler[zenoh.Reply]) -> None:
        self._replies = replies
        self.has_ended = False

    def drain(self) -> list[tuple[str, bytes]]:
        """Return key expressions and payloads that came since the last call."""
        found: list[tuple[str, bytes]] = []
        while not self.has_ended:
            try:
                reply = self._replies.try_recv()
            except zenoh.ZError:  # empty, and nothing comes any more
                self.has_ended = True
                break
            if reply is None:
                break
            if reply.ok is not None:
                found.append((str(reply.ok.key_expr), reply.ok.payload.to_bytes()))
        return found


class RecordingReader:
    """Reader of every message of every topic, almost without loss as far as the publishers' caches reach back.

    It also receives what was published while no router was running, but not what was published before it discovered
    the publisher. It asks for what it missed by itself, but only once: right after a reconnection, while the router
    does not know yet who has a cache, nobody answers. ``ask`` asks again.
    """

    def __init__(
        self, session: zenoh.Session, subscriber: ext.AdvancedSubscriber[handlers.Handler[zenoh.Sample]]
    ) -> None:
        self._session = session
        self._subscriber = subscriber

    def end(self) -> None:
        """Stop reading and drop the messages in the buffer."""
        undeclare: Callable[[], None] = self._subscriber.undeclare  # without types in its stub
        undeclare()

    def drain(self) -> list[tuple[str, bytes]]:
        """Return key expressions and payloads received since the last call; those of one publisher in order."""
        samples = islice(iter(self._subscriber.try_recv, None), RECORDING_QUEUE)
        return [(str(sample.key_expr), sample.payload.to_bytes()) for sample in samples]

    def ask(self, key: str, first: int, last: int) -> CacheAnswer:
        """Ask the caches of a key's publishers for some of their messages.

        Args:
            key: Key expression under which they publish.
            first: The first message, counted from 0 in each session.
            last: The last one.
        """
        replies = self._session.get(
            f"{key}/{CACHE}?_sn={first}..{last};_anyke",
            handlers.FifoChannel(last - first + 1),
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=CACHE_TIMEOUT_S,
        )
        return CacheAnswer(replies)
