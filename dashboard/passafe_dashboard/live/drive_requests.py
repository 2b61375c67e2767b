"""Let pages drive: one at a time, through the operator process, each is shown who does."""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import Any, Final, TypeAlias

from passafe_protocol.messages import Steer

from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.drive_state import NS_PER_MS, driver_json, other_operator
from passafe_dashboard.live.driver_seat import PageCommand

CLOCK_HZ: Final = 20.0
"""Rate of the clock messages, and of the repeats of who drives."""

PENDING: Final = 16
"""Messages that wait for a page that reads slowly, its newest clock aside."""

Publish: TypeAlias = Callable[[Steer, int], None]
"""Publishes who drives at a monotonic time, ns."""

Echo: TypeAlias = Callable[[int], tuple[int, int, int]]
"""Returns session and ``scheduled_ns`` of the newest command of an operator, and the time since its arrival, ns."""


class DrivingPage:
    """One page's side of the connection: what waits to be sent to it, the newest.

    Attributes:
        number: Its number, from 1.
    """

    def __init__(self, number: int) -> None:
        """Start with nothing to send."""
        self.number = number
        self._clock: str | None = None
        self._texts: deque[str] = deque(maxlen=PENDING)
        self._waits = asyncio.Event()

    def show_clock(self, text: str) -> None:
        """Send a clock message in the place of one that waits."""
        self._clock = text
        self._waits.set()

    def send(self, message: dict[str, Any]) -> None:
        """Send a message."""
        self._texts.append(json_text(message))
        self._waits.set()

    async def next_texts(self) -> list[str]:
        """Wait for something to send; remove and return all of it."""
        await self._waits.wait()
        self._waits.clear()
        texts = [*self._texts, *([] if self._clock is None else [self._clock])]
        self._texts.clear()
        self._clock = None
        return texts


class DriveRequests:
    """Seat of the driver with its pages and the way to the operator.

    Args:
        broadcast: Source of the lease, the scenario and the clock.
        publish: Publishes who drives.
        echo: Echo of the operator's newest command.
    """

    def __init__(self, broadcast: Broadcast, publish: Publish, echo: Echo) -> None:
        self._broadcast = broadcast
        self._seat = broadcast.feed.seat
        self._publish = publish
        self._echo = echo
        self._pages: dict[int, DrivingPage] = {}
        self._numbered = 0
        self._reported: tuple[int, str] = (0, "")

    @property
    def pages(self) -> int:
        """Number of connected pages that may drive."""
        return len(self._pages)

    def now_ns(self) -> int:
        """Return the server's monotonic clock."""
        return self._broadcast.clock()

    def join(self) -> DrivingPage:
        """Add a page and tell it who drives."""
        self._numbered += 1
        page = self._pages[self._numbered] = DrivingPage(self._numbered)
        self._seat.pages = len(self._pages)
        page.send(self._driver_message(page, ""))
        return page

    def leave(self, page: DrivingPage) -> None:
        """Remove a page; the seat is free if it was its."""
        del self._pages[page.number]
        self._seat.pages = len(self._pages)
        self.release(page, "the page was closed")

    def take(self, page: DrivingPage, *, over: bool) -> None:
        """Let a page take the seat, or tell it why it cannot."""
        refusal = self._seat.take(page.number, self.now_ns(), over=over, other=other_operator(self._broadcast.feed))
        if refusal:
            page.send(self._driver_message(page, refusal))
        self._report_changes()

    def steer(self, page: DrivingPage, command: PageCommand) -> None:
        """Pass a page's command on to the operator if it counts."""
        if self._seat.steer(page.number, command, self.now_ns()):
            self._send()
        self._report_changes()

    def release(self, page: DrivingPage, reason: str = "released") -> None:
        """Free the seat if the page has it."""
        self._seat.release(page.number, self.now_ns(), reason)
        self._report_changes()

    def hand_to_script(self, page: DrivingPage) -> None:
        """Hand the seat to the operator's script, or tell the page why it cannot."""
        refusal = self._seat.hand_to_script(page.number, self.now_ns())
        if refusal:
            page.send(self._driver_message(page, refusal))
        self._report_changes()

    async def run(self) -> None:
        """Show the clock, repeat who drives and free the seat of a silent page, until cancelled."""
        while True:
            self.step()
            await asyncio.sleep(1.0 / CLOCK_HZ)

    def step(self) -> None:
        """Do once what ``run`` repeats."""
        now_ns = self.now_ns()
        lease = self._broadcast.feed.lease
        self._seat.expire(now_ns)
        if lease is not None:
            self._seat.observe(lease, now_ns)
        self._report_changes()
        self._send()
        text = json_text({"type": "clock", "server_ms": now_ns / NS_PER_MS})
        for page in self._pages.values():
            page.show_clock(text)

    def _send(self) -> None:
        now_ns = self.now_ns()
        message = self._seat.message(now_ns, self._echo(now_ns))
        if message is not None:
            self._publish(message, now_ns)

    def _report_changes(self) -> None:
        """Report who drives to every page, and at once to the operator, if that changed."""
        reported = (self._seat.turn, other_operator(self._broadcast.feed))
        if reported == self._reported:
            return
        is_new_turn, self._reported = reported[0] != self._reported[0], reported
        if is_new_turn:
            self._send()
        for page in self._pages.values():
            page.send(self._driver_message(page, self._seat.reason))

    def _driver_message(self, page: DrivingPage, reason: str) -> dict[str, Any]:
        return {
            "type": "driver",
            "page": str(page.number),
            "you": self._seat.page == page.number,
            "driver": driver_json(self._broadcast.feed),
            "reason": reason,
        }
