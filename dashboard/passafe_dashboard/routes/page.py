"""Serve the live page: ``GET /`` and the script of its charts, ``GET /charts.js``."""

import asyncio

from fastapi import APIRouter, Response
from fastapi.responses import HTMLResponse

from passafe_dashboard.live.page import LivePage


def page_routes(page: LivePage) -> APIRouter:
    """Return the routes of the page's markup and of its charts."""
    router = APIRouter()

    @router.get("/")
    async def markup() -> HTMLResponse:
        return HTMLResponse(await asyncio.to_thread(page.html))

    @router.get("/charts.js")
    async def charts() -> Response:
        made = await asyncio.to_thread(page.charts)
        return Response(made.script, media_type="text/javascript")

    return router
