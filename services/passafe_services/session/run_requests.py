"""Requests of the page to a session: checked, refused with a reason, or carried out."""

import asyncio
from collections.abc import Callable
from typing import Final

from passafe.errors import NotAllowedError, PassafeError
from passafe_services.loop.daemon_thread import in_daemon_thread
from passafe_services.loop.process_name import ProcessName
from passafe_services.session.control_messages import (
    EndRun,
    KillProcess,
    PageRequest,
    Refusal,
    RestartProcess,
    RunChoices,
    StartRun,
)
from passafe_services.session.planned_run import PlannedRun
from passafe_services.session.run_session import RunSession

START_STOPPED: Final = ("--start-stopped",)
"""Option of a plant that starts with its emergency stop latched."""

Prepare = Callable[[StartRun], PlannedRun]
"""Prepares a run: reads its scenario, checks its design, writes its scenario's file; takes seconds."""


class RunRequests:
    """Requests to a session; of several runs that are requested at a time, the newest wins.

    Args:
        session: The session.
        prepare: Prepares a run, in a thread of its own; raises PassafeError for one that is not possible.
    """

    def __init__(self, session: RunSession, prepare: Prepare) -> None:
        self._session = session
        self._prepare = prepare
        self._newest = 0
        self._preparing: RunChoices | None = None
        self._one_at_a_time = asyncio.Lock()

    async def handle(self, request: PageRequest) -> Refusal | None:
        """Carry out a request; return why it is refused, or ``None``."""
        match request:
            case StartRun():
                return await self._start(request)
            case EndRun():
                self._newest += 1  # a run that is being prepared is not wanted any more
                return None if self._session.end() else Refusal(reason="no run is going on")
            case KillProcess():
                return self._kill(request.process)
            case RestartProcess():
                return self._restart(request.process, START_STOPPED if request.start_stopped else ())

    async def _start(self, request: StartRun) -> Refusal | None:
        if request.choices == self._coming:
            return None  # asked for twice
        self._newest += 1
        own, self._preparing = self._newest, request.choices
        try:
            return await self._start_unless_overtaken(request, own)
        except NotAllowedError as error:
            return Refusal(field=error.field, reason=str(error))
        except PassafeError as error:
            return Refusal(field="scenario", reason=str(error))
        except (RuntimeError, MemoryError) as error:
            return Refusal(reason=f"the run cannot be prepared: {error}")
        finally:
            if own == self._newest:
                self._preparing = None

    async def _start_unless_overtaken(self, request: StartRun, own: int) -> Refusal | None:
        async with self._one_at_a_time:
            if own != self._newest:
                return _OVERTAKEN
            run = await in_daemon_thread(lambda: self._prepare(request))
        if own != self._newest:
            run.discard()
            return _OVERTAKEN
        self._session.start(run)
        return None

    @property
    def _coming(self) -> RunChoices | None:
        """Choices of the run that is being prepared, waits or starts."""
        session = self._session
        if self._preparing is not None:
            return self._preparing
        if session.wanted is not None:
            return session.wanted.choices
        return session.present.choices if session.phase == "starting" else None

    def _kill(self, name: ProcessName) -> Refusal | None:
        if "kill" in self._session.permitted(name) and self._session.kill(name):
            return None
        return self._refused("kill", name)

    def _restart(self, name: ProcessName, options: tuple[str, ...]) -> Refusal | None:
        if name is not ProcessName.PLANT:
            options = ()
        if "restart" in self._session.permitted(name) and self._session.restart(name, *options):
            return None
        return self._refused("restart", name)

    def _refused(self, action: str, name: ProcessName) -> Refusal:
        if name is ProcessName.DASHBOARD:
            return Refusal(reason="the page cannot ask for its own end")
        if name is ProcessName.RECORDER and action == "restart":
            return Refusal(reason="the log would be in two parts: start another run")
        if self._session.phase in {"starting", "stopping"}:
            return Refusal(reason=f"a run is {self._session.phase}: ask again when that is over")
        return Refusal(reason=f"no {name} is running that could be asked to {action}")


_OVERTAKEN: Final = Refusal(reason="a later request took its place")
