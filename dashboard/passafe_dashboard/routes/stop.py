"""Serve the emergency stop: press it with ``PUT /api/stop``, clear one by its id with ``PUT /api/clear/{stop}``."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, HTTPException, Path, Response

from passafe_dashboard.errors import StopAnswerError, StopNameError
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.stop_requests import StopRequests

CONFLICT: Final = 409
GATEWAY_TIMEOUT: Final = 504

StopId = Annotated[int, Path(ge=1, lt=2**64)]


def stop_routes(stops: StopRequests) -> APIRouter:
    """Return the routes that press and clear the emergency stop."""
    router = APIRouter()

    @router.put("/api/stop")
    async def press() -> Response:
        try:
            return _json(await stops.press())
        except StopAnswerError as error:
            raise HTTPException(GATEWAY_TIMEOUT, str(error)) from error

    @router.put("/api/clear/{stop}")
    async def clear(stop: StopId) -> Response:
        try:
            return _json(await stops.clear(stop))
        except StopNameError as error:
            raise HTTPException(CONFLICT, str(error)) from error
        except StopAnswerError as error:
            raise HTTPException(GATEWAY_TIMEOUT, str(error)) from error

    return router


def _json(value: dict[str, Any]) -> Response:
    return Response(json_text(value), media_type="application/json")
