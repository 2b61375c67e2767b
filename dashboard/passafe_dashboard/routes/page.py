"""Serve the live page: ``GET /``, and ``GET /engineer`` for its second sheet."""

import asyncio

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, RedirectResponse

from passafe_dashboard.live.page import LivePage


def page_routes(page: LivePage) -> APIRouter:
    """Return the routes of the page's markup."""
    router = APIRouter()

    @router.get("/")
    async def markup() -> HTMLResponse:
        return HTMLResponse(await asyncio.to_thread(page.html))

    @router.get("/engineer", include_in_schema=False)
    async def engineer() -> RedirectResponse:
        return RedirectResponse("/#engineer")

    return router
