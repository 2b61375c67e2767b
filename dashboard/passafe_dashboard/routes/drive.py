"""Serve driving: the WebSocket ``/drive``, over which a page takes the wheel, steers and gives it back."""

import asyncio
from typing import Final

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.drive_requests import DriveRequests, DrivingPage
from passafe_dashboard.live.drive_state import NS_PER_MS, drive_setup
from passafe_dashboard.live.driver_seat import PageCommand
from passafe_dashboard.routes.drive_messages import PageMessage, PageSteer, Release, Script, Take, parsed, refusal

MAX_PAGES: Final = 32
MAX_REFUSED: Final = 10
"""Messages that are refused before the connection is closed."""

MESSAGES_PER_S: Final = 200.0
"""Messages a second that a page may send for long; so many at once."""

CLOCK_ERROR_MS: Final = 20.0
"""By so much may a page's clock run ahead of ours between two clock messages."""

TRY_AGAIN_LATER: Final = 1013
POLICY_VIOLATION: Final = 1008


def drive_routes(broadcast: Broadcast, drives: DriveRequests) -> APIRouter:
    """Return the route of driving.

    Args:
        broadcast: Source of the scenario.
        drives: The driver's seat and its pages.
    """
    router = APIRouter()

    @router.websocket("/drive")
    async def drive(websocket: WebSocket) -> None:
        if drives.pages >= MAX_PAGES:
            await websocket.accept()
            await websocket.close(TRY_AGAIN_LATER, "too many pages are open")
            return
        page = drives.join()  # before anything is awaited: others connect meanwhile
        try:
            await websocket.accept()
            async with asyncio.TaskGroup() as tasks:
                sending = tasks.create_task(_send(websocket, page))
                reason = await DriveConnection(websocket, page, drives, broadcast).read()
                sending.cancel()
            await websocket.close(POLICY_VIOLATION, reason)
        except* WebSocketDisconnect:
            pass  # the page was closed
        finally:
            drives.leave(page)

    return router


async def _send(websocket: WebSocket, page: DrivingPage) -> None:
    while True:
        for text in await page.next_texts():
            await websocket.send_text(text)


class DriveConnection:
    """One page's messages: checked, in order, at a bounded rate.

    Args:
        websocket: The connection.
        page: The page.
        drives: The driver's seat.
        broadcast: Source of the scenario.
    """

    def __init__(self, websocket: WebSocket, page: DrivingPage, drives: DriveRequests, broadcast: Broadcast) -> None:
        self._websocket = websocket
        self._page = page
        self._drives = drives
        self._feed = broadcast.feed
        self._refused = 0
        self._number = -1
        self._allowance = MESSAGES_PER_S
        self._before_ns = drives.now_ns()

    async def read(self) -> str:
        """Read messages until the page leaves, which raises WebSocketDisconnect, or has to; return why."""
        while True:
            message = await self._websocket.receive()
            if message["type"] == "websocket.disconnect":
                raise WebSocketDisconnect(message.get("code", 1006))
            if not self._is_in_rate():
                return f"more than {MESSAGES_PER_S:g} messages a second"
            answer = self.answer(message.get("text"))
            if answer is not None:
                self._refused += 1
                self._page.send(answer)
            if self._refused >= MAX_REFUSED:
                return f"{MAX_REFUSED} messages were refused"

    def answer(self, text: str | None) -> dict[str, object] | None:
        """Act on a message; return the answer if it is refused."""
        if text is None:
            return refusal("message", "bytes", "JSON text")
        message = parsed(text)
        return message if isinstance(message, dict) else self._act(message)

    def _act(self, message: PageMessage) -> dict[str, object] | None:
        match message:
            case Take():
                self._drives.take(self._page, over=message.over)
            case Release():
                self._drives.release(self._page)
            case Script():
                self._drives.hand_to_script(self._page)
            case PageSteer():
                return self._steer(message)
        return None

    def _steer(self, message: PageSteer) -> dict[str, object] | None:
        setup = drive_setup(self._feed.scenario)
        axes = 0 if setup is None else setup["axes"]
        if len(message.shares) != axes:
            return refusal("steer.shares", f"{len(message.shares)} numbers", f"{axes}, one for each input")
        now_ms = self._drives.now_ns() / NS_PER_MS
        age_ms = now_ms - message.echo_ms - message.held_ms
        if age_ms < -CLOCK_ERROR_MS:
            made_ms = message.echo_ms + message.held_ms
            return refusal(
                "steer.echo_ms + held_ms", f"{made_ms:.0f}", f"at most {now_ms:.0f}, the clock of the server"
            )
        if message.number > self._number:  # one out of order is late, not wrong
            self._number = message.number
            made_ns = round((now_ms - max(age_ms, 0.0)) * NS_PER_MS)
            command = PageCommand(shares=tuple(message.shares), engaged=message.engaged, made_ns=made_ns)
            self._drives.steer(self._page, command)
        return None

    def _is_in_rate(self) -> bool:
        now_ns = self._drives.now_ns()
        earned = (now_ns - self._before_ns) / 1e9 * MESSAGES_PER_S
        self._allowance = min(self._allowance + earned, MESSAGES_PER_S) - 1.0
        self._before_ns = now_ns
        return self._allowance >= 0.0
