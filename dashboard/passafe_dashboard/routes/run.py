"""Serve the session of a demo: start and end runs with ``/api/run``, kill and restart processes."""

from http import HTTPStatus
from typing import Annotated, Any, Final

from fastapi import APIRouter, HTTPException
from fastapi.exceptions import RequestValidationError
from passafe_services.loop.process_name import ProcessName
from passafe_services.session.control_messages import (
    EndRun,
    KillProcess,
    PageRequest,
    RestartProcess,
    RunChoices,
    SessionState,
    StartRun,
)
from pydantic import BaseModel, Field

from passafe_dashboard.errors import NoSessionError, SessionAnswerError, SessionRefusedError
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.session_requests import SessionRequests
from passafe_dashboard.routes.answers import refused

ACCEPTED: Final = 202
CONFLICT, GATEWAY_TIMEOUT = HTTPStatus.CONFLICT, HTTPStatus.GATEWAY_TIMEOUT

LONGEST_NAME: Final = 4096


class RunRequest(RunChoices):
    """Choices of a run; of what is null, the demo's command line decides, and else the scenario."""

    scenario: Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]


class Accepted(BaseModel):
    """A request was accepted; what comes of it is seen in the state of the session.

    Attributes:
        run: Number of the run that was going on.
    """

    run: int


def run_routes(session: SessionRequests, feed: Feed) -> APIRouter:
    """Return the routes that start and end runs, and kill and restart processes.

    Args:
        session: Asks the supervisor of the demo.
        feed: Where the state of the session is.
    """
    impossible = refused(CONFLICT, "Not possible now, or no demo")
    silent = refused(GATEWAY_TIMEOUT, "No answer from the demo's supervisor")
    router = APIRouter(tags=["runs"], responses=impossible | silent)

    @router.get("/api/run")
    async def state() -> SessionState | None:
        return None if feed.session is None else SessionState.model_validate(feed.session)

    @router.post("/api/run", status_code=ACCEPTED)
    async def start(choices: RunRequest) -> Accepted:
        asked = RunChoices(**choices.model_dump())
        return await _answer(session, StartRun(choices=asked, start_stopped=session.is_stopped))

    @router.delete("/api/run", status_code=ACCEPTED)
    async def end() -> Accepted:
        return await _answer(session, EndRun())

    @router.post("/api/processes/{name}/kill", status_code=ACCEPTED)
    async def kill(name: ProcessName) -> Accepted:
        return await _answer(session, KillProcess(process=name))

    @router.post("/api/processes/{name}/restart", status_code=ACCEPTED)
    async def restart(name: ProcessName) -> Accepted:
        return await _answer(session, RestartProcess(process=name, start_stopped=session.is_stopped))

    return router


async def _answer(session: SessionRequests, request: PageRequest) -> Accepted:
    try:
        return Accepted(run=await session.ask(request))
    except NoSessionError as error:
        raise HTTPException(CONFLICT, str(error)) from error
    except SessionAnswerError as error:
        raise HTTPException(GATEWAY_TIMEOUT, str(error)) from error
    except SessionRefusedError as error:
        if not error.field:
            raise HTTPException(CONFLICT, str(error)) from error
        detail: dict[str, Any] = {"type": "value_error", "loc": ("body", error.field), "msg": str(error), "input": None}
        raise RequestValidationError([detail]) from error
