"""Serve the page's state: ``GET /api/status``, ``GET /healthz``, and frame by frame the WebSocket ``/live``."""

import asyncio
from collections.abc import Callable
from contextlib import aclosing
from typing import Final

from fastapi import APIRouter, Request, Response, WebSocket, WebSocketDisconnect

from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.page_state import liveness, page_state

MAX_CLIENTS: Final = 32
TRY_AGAIN_LATER: Final = 1013


def state_routes(broadcast: Broadcast, bus_trouble: Callable[[], str]) -> APIRouter:
    """Return the routes of state, health and frames.

    Args:
        broadcast: Source of the state and of the frames.
        bus_trouble: Says why nothing can be read from the bus; empty if that is not so.
    """
    router = APIRouter(tags=["state"])
    served: set[WebSocket] = set()

    @router.get("/api/status")
    async def status() -> Response:
        """Return the state of the page, which each frame of ``/live`` has as ``now``."""
        text = json_text(page_state(broadcast.feed, broadcast.clock()))
        return Response(text, media_type="application/json")

    @router.get("/healthz", responses={503: {"description": "It does not; answered alike"}})
    async def healthz(request: Request) -> Response:
        """Return whether the dashboard reads the bus, and how current what it shows is."""
        broadcasting: asyncio.Task[None] = request.app.state.broadcasting
        trouble = "reading the bus has failed" if broadcasting.done() else bus_trouble()
        feed = liveness(broadcast.feed, broadcast.clock())
        text = json_text({"ok": not trouble, "trouble": trouble, "pages": broadcast.clients, "feed": feed})
        return Response(text, media_type="application/json", status_code=503 if trouble else 200)

    @router.websocket("/live")
    async def live(websocket: WebSocket) -> None:
        if len(served) >= MAX_CLIENTS:
            await websocket.accept()
            await websocket.close(TRY_AGAIN_LATER, "too many pages are open")
            return
        served.add(websocket)  # before anything is awaited: others connect meanwhile
        try:
            await websocket.accept()
            await _serve_client(websocket, broadcast)
        finally:
            served.discard(websocket)

    return router


async def _serve_client(websocket: WebSocket, broadcast: Broadcast) -> None:
    """Send frames until the client leaves or the run is over."""
    try:
        async with asyncio.TaskGroup() as tasks:
            waiting = tasks.create_task(_wait_for_departure(websocket))
            sending = tasks.create_task(_send_frames(websocket, broadcast))
            sending.add_done_callback(lambda _: waiting.cancel())
    except* WebSocketDisconnect:
        pass  # the page was closed: nothing is left to send to


async def _send_frames(websocket: WebSocket, broadcast: Broadcast) -> None:
    async with aclosing(broadcast.frames()) as frames:
        async for text in frames:
            await websocket.send_text(text)
    await websocket.close(reason="the run is over")


async def _wait_for_departure(websocket: WebSocket) -> None:
    """Read and ignore messages until the client leaves, which raises WebSocketDisconnect."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1006))
