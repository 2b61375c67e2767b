"""From one feed to many clients, at a bounded rate: a slow client waits alone and loses the oldest rows."""

import asyncio
from collections.abc import AsyncGenerator, Callable
from typing import Final, TypeAlias

from passafe_services.loop.pace import Pace

from passafe_dashboard.decimation import NS_PER_S
from passafe_dashboard.feed import Feed
from passafe_dashboard.frames import ClientView, json_text
from passafe_dashboard.snapshot import status_json

FRAME_HZ: Final = 30.0
REST_S: Final = 0.002
"""Least time left to everybody else between two frames, however far behind they are."""

Pump: TypeAlias = Callable[[int, Pace], None]
"""Moves what has arrived by a time, ns, into the feed and returns at once; may report the frames' pace."""


class Broadcast:
    """Pumps messages into the feed and wakes the clients, ``frame_hz`` times a second.

    All of it runs in one event loop, so nothing is locked: the pump runs to its end between two frames. Each
    client sends in a task of its own and asks for the next frame when the last one is gone.

    Attributes:
        feed: The feed.
        clock: Monotonic clock, ns, the one that stamps arrivals.
        pace: When frames were due and how late they were.

    Args:
        feed: The feed.
        pump: Where messages come from.
        clock: Monotonic clock, ns, the one that stamps arrivals.
        frame_hz: Frames a second.
    """

    def __init__(self, feed: Feed, *, pump: Pump, clock: Callable[[], int], frame_hz: float = FRAME_HZ) -> None:
        self.feed = feed
        self.clock = clock
        self.pace = Pace(clock(), frame_hz)
        self._pump = pump
        self._frame_hz = frame_hz
        self._clients = 0
        self._next = asyncio.Event()
        self._now_text: str | None = None

    @property
    def clients(self) -> int:
        """Number of pages that listen."""
        return self._clients

    async def run(self) -> None:
        """Pump and wake clients until cancelled."""
        self.pace = Pace(self.clock(), self._frame_hz)
        while True:
            self.step()
            await asyncio.sleep(max(REST_S, (self.pace.due_ns - self.clock()) / NS_PER_S))

    def step(self) -> None:
        """Pump once and let every waiting client have a frame."""
        now_ns = self.clock()
        self.pace.begin(now_ns)
        self._pump(now_ns, self.pace)
        self._publish()
        self.pace.end(self.clock())

    def finish(self, reason: str) -> None:
        """Give every client a last frame that says why the run is over."""
        self._pump(self.clock(), self.pace)
        self.feed.finish(reason)
        self._publish()

    async def next_frame(self) -> None:
        """Wait until messages have been pumped once more."""
        await self._next.wait()

    async def frames(self) -> AsyncGenerator[str, None]:
        """Frames for one client, the whole history in the first; ends after the one that says so."""
        view = ClientView(self.feed)
        self._clients += 1
        try:
            while self.feed.end is None:
                await self._next.wait()
                yield view.frame(self._now())
            if not view.has_seen_end:
                yield view.frame(self._now())
        finally:
            self._clients -= 1

    def _now(self) -> str:
        """State now as JSON, made once a frame however many clients ask."""
        if self._now_text is None:
            self._now_text = json_text(status_json(self.feed, self.clock()))
        return self._now_text

    def _publish(self) -> None:
        self._now_text = None
        self._next.set()
        self._next = asyncio.Event()
