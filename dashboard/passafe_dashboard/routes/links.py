"""Serve the links: read all with ``GET /api/links``, change one with ``PUT /api/links/{name}``."""

from typing import Any, Final

from fastapi import APIRouter, HTTPException, Response
from fastapi.exceptions import RequestValidationError
from passafe_protocol.topics import LINKS

from passafe_dashboard.errors import LinkAnswerError, LinkUpdateError
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.link_requests import LinkRequests, LinkUpdate

NOT_FOUND: Final = 404
GATEWAY_TIMEOUT: Final = 504


def link_routes(links: LinkRequests) -> APIRouter:
    """Return the routes that read and change links."""
    router = APIRouter()

    @router.get("/api/links")
    async def states() -> Response:
        return _json({"links": links.states()})

    @router.put("/api/links/{name}")
    async def change(name: str, update: LinkUpdate) -> Response:
        if name not in LINKS:
            raise HTTPException(NOT_FOUND, f"link: got {name!r}, allowed {', '.join(LINKS)}")
        try:
            return _json(await links.change(name, update))
        except LinkUpdateError as error:
            detail = {"type": "value_error", "loc": ("body", *error.loc), "msg": error.allowed, "input": error.got}
            raise RequestValidationError([detail]) from error
        except LinkAnswerError as error:
            raise HTTPException(GATEWAY_TIMEOUT, str(error)) from error

    return router


def _json(value: dict[str, Any]) -> Response:
    return Response(json_text(value), media_type="application/json")
