"""Serve the emergency stop: press it with ``PUT /api/stop``, clear one by its id with ``PUT /api/clear/{stop}``."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, HTTPException, Path
from pydantic import BaseModel

from passafe_dashboard.errors import NothingToStopError, StopAnswerError, StopNameError
from passafe_dashboard.live.stop_requests import StopRequests
from passafe_dashboard.routes.answers import refused

CONFLICT, GATEWAY_TIMEOUT = HTTPStatus.CONFLICT, HTTPStatus.GATEWAY_TIMEOUT

StopId = Annotated[int, Path(ge=1, lt=2**64)]


class LatchedStop(BaseModel):
    """Emergency stop that the plant has latched.

    Attributes:
        id: Its id, as text; null: none is latched.
        source: Process that pressed it.
    """

    id: str | None
    source: str | None


def stop_routes(stops: StopRequests) -> APIRouter:
    """Return the routes that press and clear the emergency stop."""
    silent = refused(GATEWAY_TIMEOUT, "The plant did not answer")
    router = APIRouter(tags=["emergency stop"], responses=silent)

    @router.put("/api/stop", responses=refused(CONFLICT, "No run is going on"))
    async def press() -> LatchedStop:
        """Press the emergency stop; answered when the plant has latched it."""
        try:
            return LatchedStop(**await stops.press())
        except NothingToStopError as error:
            raise HTTPException(CONFLICT, str(error)) from error
        except StopAnswerError as error:
            raise HTTPException(GATEWAY_TIMEOUT, str(error)) from error

    @router.put("/api/clear/{stop}", responses=refused(CONFLICT, "Another stop is latched, or none"))
    async def clear(stop: StopId) -> LatchedStop:
        """Clear the stop of this id; answered when the plant has done so."""
        try:
            return LatchedStop(**await stops.clear(stop))
        except StopNameError as error:
            raise HTTPException(CONFLICT, str(error)) from error
        except StopAnswerError as error:
            raise HTTPException(GATEWAY_TIMEOUT, str(error)) from error

    return router
