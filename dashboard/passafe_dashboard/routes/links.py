"""Serve the links: read all with ``GET /api/links``, change one with ``PUT /api/links/{name}``."""

from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, HTTPException, Response
from fastapi.exceptions import RequestValidationError
from passafe_protocol.topics import LINKS
from pydantic import BaseModel

from passafe_dashboard.errors import LinkAnswerError, LinkUpdateError
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.link_requests import LinkRequests, LinkUpdate
from passafe_dashboard.routes.answers import UNKNOWN_NAME, refused

OK, NOT_FOUND, GATEWAY_TIMEOUT = HTTPStatus.OK, HTTPStatus.NOT_FOUND, HTTPStatus.GATEWAY_TIMEOUT


class LinkAnswer(BaseModel):
    """An injected link; null until its state was received.

    Attributes:
        link: Its name.
        topic: Topic whose messages it carries.
        reader: Process at whose inlet it sits.
        age_s: Time since its state was received.
        settings: Settings in force, by the names of ``LinkParameters`` on the wire, and the opportunities of a trace.
        counts: Messages by what became of them.
    """

    link: str
    topic: str
    reader: str
    age_s: float | None
    settings: dict[str, Any] | None
    counts: dict[str, int] | None


class LinkList(BaseModel):
    """Every injected link.

    Attributes:
        links: They.
    """

    links: list[LinkAnswer]


def link_routes(links: LinkRequests) -> APIRouter:
    """Return the routes that read and change links."""
    router = APIRouter(tags=["links"])

    @router.get("/api/links", responses={OK: {"model": LinkList}})
    async def states() -> Response:
        """Return every link."""
        return _json({"links": links.states()})

    answers = {OK: {"model": LinkAnswer}} | UNKNOWN_NAME | refused(GATEWAY_TIMEOUT, "Its reader did not answer")

    @router.put("/api/links/{name}", responses=answers)
    async def change(name: str, update: LinkUpdate) -> Response:
        """Change settings of a link; answered with those in force. Settings that are not given keep their value."""
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
