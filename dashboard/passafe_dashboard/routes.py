"""The web application: the live page, its WebSocket, and the state as JSON."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import aclosing, asynccontextmanager
from pathlib import Path
from typing import Final

from bokeh.settings import settings as bokeh_settings
from fastapi import APIRouter, FastAPI, Request, Response, WebSocket, WebSocketDisconnect
from fastapi.responses import HTMLResponse
from fastapi.staticfiles import StaticFiles

from passafe_dashboard.broadcast import Broadcast
from passafe_dashboard.frames import json_text
from passafe_dashboard.link_requests import LinkRequests
from passafe_dashboard.link_routes import link_routes
from passafe_dashboard.origin import same_origin
from passafe_dashboard.page import LivePage
from passafe_dashboard.snapshot import liveness_json, status_json

MAX_CLIENTS: Final = 32
WRONG_ORIGIN: Final = 1008
TRY_AGAIN_LATER: Final = 1013
HEADERS: Final = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
        "style-src 'self' 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}
"""The browser loads nothing from other hosts. Inline styles stay allowed: BokehJS styles its elements so."""


def create_app(broadcast: Broadcast, links: LinkRequests, *, window_s: float = 20.0) -> FastAPI:
    """Make the application.

    While it runs, ``app.state.broadcasting`` is the task that pumps messages; it ends only by failing.

    Args:
        broadcast: What to show, and where it comes from.
        links: Changes links.
        window_s: Stretch of time that charts show.
    """
    page = LivePage(broadcast.feed, window_s=window_s)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await asyncio.to_thread(page.charts)  # before messages flow: it takes a second in a new process
        app.state.broadcasting = asyncio.create_task(broadcast.run())
        yield
        app.state.broadcasting.cancel()
        await asyncio.wait({app.state.broadcasting})

    app = FastAPI(title="passafe dashboard", lifespan=lifespan, docs_url=None, redoc_url=None, openapi_url=None)
    app.middleware("http")(_add_headers)
    app.include_router(_page_routes(page))
    app.include_router(_state_routes(broadcast))
    app.include_router(link_routes(links))
    app.mount("/static/bokeh", StaticFiles(directory=bokeh_settings.bokehjs_path()), name="bokeh")
    app.mount("/static", StaticFiles(directory=Path(__file__).parent / "static"), name="static")
    return app


async def _add_headers(request: Request, call_next: Callable[[Request], Awaitable[Response]]) -> Response:
    response = await call_next(request)
    for name, value in HEADERS.items():
        response.headers.setdefault(name, value)
    return response


def _page_routes(page: LivePage) -> APIRouter:
    router = APIRouter()

    @router.get("/")
    async def live_page() -> HTMLResponse:
        return HTMLResponse(await asyncio.to_thread(page.html))

    @router.get("/charts.js")
    async def charts() -> Response:
        made = await asyncio.to_thread(page.charts)
        return Response(made.script, media_type="text/javascript")

    return router


def _state_routes(broadcast: Broadcast) -> APIRouter:
    router = APIRouter()

    @router.get("/api/status")
    async def status() -> Response:
        text = json_text(status_json(broadcast.feed, broadcast.clock()))
        return Response(text, media_type="application/json")

    @router.get("/healthz")
    async def healthz(request: Request) -> Response:
        pumping: asyncio.Task[None] = request.app.state.broadcasting
        liveness = liveness_json(broadcast.feed, broadcast.clock())
        text = json_text({"ok": not pumping.done(), "pages": broadcast.clients, "feed": liveness})
        return Response(text, media_type="application/json", status_code=503 if pumping.done() else 200)

    @router.websocket("/live")
    async def live(websocket: WebSocket) -> None:
        if not same_origin(websocket):
            await websocket.close(WRONG_ORIGIN)
            return
        await websocket.accept()
        if broadcast.clients >= MAX_CLIENTS:
            await websocket.close(TRY_AGAIN_LATER, "too many pages are open")
            return
        await _serve_client(websocket, broadcast)

    return router


async def _serve_client(websocket: WebSocket, broadcast: Broadcast) -> None:
    """Send frames until the client leaves or the run is over."""
    try:
        async with asyncio.TaskGroup() as tasks:
            listening = tasks.create_task(_wait_for_departure(websocket))
            sending = tasks.create_task(_send_frames(websocket, broadcast))
            sending.add_done_callback(lambda _: listening.cancel())
    except* WebSocketDisconnect:
        pass  # the page was closed: nothing is left to send to


async def _send_frames(websocket: WebSocket, broadcast: Broadcast) -> None:
    async with aclosing(broadcast.frames()) as frames:
        async for text in frames:
            await websocket.send_text(text)
    await websocket.close(reason="the run is over")


async def _wait_for_departure(websocket: WebSocket) -> None:
    """Read until the client leaves, which raises WebSocketDisconnect; what it says is not used."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1006))
