"""Read the bus and send frames to every client, at a bounded rate; a slow client delays nobody else."""

import asyncio
from collections.abc import AsyncGenerator, Callable
from typing import Final, TypeAlias

from passafe_services.loop.pace import Pace

from passafe_dashboard.decimation import NS_PER_S
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.frames import ClientFrames, Made
from passafe_dashboard.live.page_state import page_state

FRAME_HZ: Final = 34.0
MIN_SLEEP_S: Final = 0.002
"""Least time left to other tasks between two frames, however late the frames are."""

ReadBus: TypeAlias = Callable[[int, Pace], None]
"""Moves what has arrived by a time, ns, into the feed and returns at once; may report the frames' pace."""


class Broadcast:
    """Loop that reads the bus into the feed and wakes the clients, ``frame_hz`` times a second.

    All of it runs in one event loop, so nothing is locked: reading is not interrupted. Each client sends in a task of
    its own and asks for its next frame when the last one is sent; one that is slow loses the oldest rows.

    Attributes:
        feed: The feed.
        clock: Monotonic clock, ns, the one that stamps arrivals.
        pace: When frames were due and how late they were.

    Args:
        feed: The feed.
        read: Reads the bus into it.
        clock: Monotonic clock, ns, the one that stamps arrivals.
        frame_hz: Frames a second.
    """

    def __init__(self, feed: Feed, *, read: ReadBus, clock: Callable[[], int], frame_hz: float = FRAME_HZ) -> None:
        self.feed = feed
        self.clock = clock
        self.pace = Pace(clock(), frame_hz)
        self._read = read
        self._frame_hz = frame_hz
        self._clients = 0
        self._next = asyncio.Event()
        self._now_text: str | None = None
        self._made: Made = {}

    @property
    def clients(self) -> int:
        """Number of connected pages."""
        return self._clients

    async def run(self) -> None:
        """Read and wake clients until cancelled."""
        self.pace = Pace(self.clock(), self._frame_hz)
        while True:
            self.step()
            await asyncio.sleep(max(MIN_SLEEP_S, (self.pace.due_ns - self.clock()) / NS_PER_S))

    def step(self) -> None:
        """Read once and wake every waiting client."""
        now_ns = self.clock()
        self.pace.begin(now_ns)
        self._read(now_ns, self.pace)
        self._wake_clients()
        self.pace.end(self.clock())

    def finish(self, reason: str) -> None:
        """Send every client a last frame that gives the reason why the run is over."""
        self._read(self.clock(), self.pace)
        self.feed.finish(reason)
        self._wake_clients()

    async def wait_for_frame(self) -> None:
        """Wait until the bus has been read once more."""
        await self._next.wait()

    async def frames(self) -> AsyncGenerator[str, None]:
        """Yield the frames of one client, the whole history in the first; end after the one that reports the end."""
        client = ClientFrames(self.feed)
        self._clients += 1
        try:
            while self.feed.end is None:
                await self._next.wait()
                yield client.next_frame(self._state_text(), self._made)
            if not client.has_sent_end:
                yield client.next_frame(self._state_text(), self._made)
        finally:
            self._clients -= 1

    def _state_text(self) -> str:
        """Return the page's state now as JSON, made once a frame for all clients."""
        if self._now_text is None:
            self._now_text = json_text(page_state(self.feed, self.clock()))
        return self._now_text

    def _wake_clients(self) -> None:
        self._now_text, self._made = None, {}
        self._next.set()
        self._next = asyncio.Event()
