"""Answers other than success, as the description of the HTTP interface lists them."""

from http import HTTPStatus
from typing import Any, Final

from pydantic import BaseModel

Answers = dict[int | str, dict[str, Any]]
"""Descriptions by status, as FastAPI takes them."""

_TEXT: Final = {"text/plain": {"schema": {"type": "string"}}}


class RefusedRequest(BaseModel):
    """Reason of an answer that is no success.

    Attributes:
        detail: What was wrong, what was got and what is allowed.
    """

    detail: str


def refused(status: HTTPStatus, why: str) -> Answers:
    """Return the description of one answer.

    Args:
        status: Its status.
        why: When it is given.
    """
    return {status.value: {"description": why, "model": RefusedRequest}}


ANY_ROUTE: Final[Answers] = {
    **refused(HTTPStatus.BAD_REQUEST, "The body cannot be read"),
    **refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "The body is too large"),
    HTTPStatus.UNAUTHORIZED.value: {"description": "The page's token is missing or wrong", "content": _TEXT},
    HTTPStatus.FORBIDDEN.value: {"description": "Asked by a page of another site", "content": _TEXT},
    HTTPStatus.MISDIRECTED_REQUEST.value: {"description": "Another host is named", "content": _TEXT},
}
"""What any route may answer."""

UNKNOWN_NAME: Final = refused(HTTPStatus.NOT_FOUND, "Nothing has that name")
