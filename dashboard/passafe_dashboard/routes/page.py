"""Serve the live page: ``GET /``, its script, and ``GET /engineer`` for its second sheet."""

import asyncio

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from passafe_dashboard.live.page import LivePage
from passafe_dashboard.script_bundle import script_bundle


def page_routes(page: LivePage) -> APIRouter:
    """Return the routes of the page's markup."""
    router = APIRouter()

    @router.get("/", response_class=HTMLResponse)
    async def markup() -> HTMLResponse:
        return HTMLResponse(await asyncio.to_thread(page.html))

    @router.get("/live.js", include_in_schema=False)
    async def script() -> Response:
        return Response(await asyncio.to_thread(script_bundle, "live/main.js"), media_type="text/javascript")

    @router.get("/engineer", include_in_schema=False)
    async def engineer() -> RedirectResponse:
        return RedirectResponse("/#engineer")

    return router
