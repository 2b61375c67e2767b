"""Processes under supervision: started in order, restarted, killed on request, stopped in reverse order."""

import asyncio
import socket
from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Final

from passafe_services.loop.child_process import ChildProcess, Intent
from passafe_services.loop.end_requests import EndRequests
from passafe_services.loop.first_of import first_of
from passafe_services.loop.process_exit import Exit, ExitCause, RunEnd
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.session_epochs import SessionEpochs

_NO_RESOURCES: Final = (OSError, RuntimeError, MemoryError)
"""No program, file descriptor or process; no thread; no memory."""

PrintLine = Callable[[str], None]


class Supervision:
    """Supervised processes of one supervisor.

    Args:
        emit: Called with each line to print.
        ready_timeout_s: Time that a process may take to be ready, s.
        epochs: Epochs of the sessions.
        on_change: Called when a process was started, is ready or has ended.
        on_control: Called with the name of a process that was started with a control channel, and with this end of it.

    Attributes:
        end_requests: Requests to end the run, which ``start`` and ``watch`` follow.
    """

    def __init__(
        self,
        emit: PrintLine,
        *,
        ready_timeout_s: float,
        epochs: SessionEpochs,
        on_change: Callable[[], None] | None = None,
        on_control: Callable[[str, socket.socket], None] | None = None,
    ) -> None:
        self.emit = emit
        self._ready_timeout_s = ready_timeout_s
        self._epochs = epochs
        self._on_change = on_change
        self._on_control = on_control
        self._width = 0  # of the longest name
        self._children: list[ChildProcess] = []
        self._starting: list[ChildProcess] = []
        self._ended: list[ChildProcess] = []
        self._restarted_s: dict[str, list[float]] = {}  # times of restarts by name
        self.end_requests = EndRequests()
        self._request = asyncio.Event()  # of a restart

    @property
    def states(self) -> dict[str, str]:
        """State of each process by name: ``starting``, ``running``, ``restarting`` or ``down``."""
        return {child.spec.name: _state(child) for child in self._children}

    def take_exits(self) -> tuple[Exit, ...]:
        """Return the exits since the last call, in the order in which the processes ended."""
        exits = tuple(child.exit for child in self._ended)
        self._ended.clear()
        return exits

    async def start(self, specs: Sequence[ProcessSpec]) -> RunEnd | None:
        """Start each process when the previous one is ready; return the end of the run if one fails.

        Meanwhile those that ran before are restarted as their policies allow.
        """
        self._width = max([self._width, *(len(spec.name) for spec in specs)])
        try:
            for spec in specs:
                child = await self._start(spec)
                if isinstance(child, RunEnd):
                    return child
                self._children.append(child)
                self._starting.append(child)
                self._changed()
                end = await self._until_ready(child)
                if end is not None:
                    return end
        finally:
            self._starting.clear()
        return None

    async def watch(self, duration_s: float | None = None) -> RunEnd:
        """Restart processes that die, as their policies allow, and those of requests, until the run ends."""
        now_s = asyncio.get_running_loop().time
        end_s = None if duration_s is None else now_s() + duration_s
        while end_s is None or now_s() < end_s:
            end = await self._mend() or self._end_so_far()
            if end is not None:
                return end
            await self._until(self.end_requests.stop, None if end_s is None else max(0.0, end_s - now_s()))
        end = await self._mend() or self._end_so_far()
        return end or RunEnd(cause=ExitCause.DURATION, culprit=None, detail=f"{duration_s:g} s are over")

    async def stop(self, names: Collection[str] | None = None) -> None:
        """Stop processes, all if no names are given, the last started first, and wait until they have ended."""
        for child in reversed(self._children.copy()):
            if names is None or child.spec.name in names:
                await self._stop_child(child)
                self._children.remove(child)

    def kill(self, name: str, *, restart: bool = False) -> bool:
        """Kill a process on request; return whether there was one.

        Args:
            name: The process.
            restart: Whether it is restarted at once, as one with a restart policy always is; else it stays down until
                ``restart``.
        """
        child = self._child(name)
        if child is None or not child.running:
            return False
        stays = child.spec.restarts is None and not restart
        child.intent = Intent.STAY_DOWN if stays else Intent.RESTART
        child.kill()
        return True

    def restart(self, name: str, *options: str) -> bool:
        """Stop a process if it still runs, and start it again, on request; return whether there is one.

        Args:
            name: The process.
            options: Options of the next one beside those of its specification.
        """
        child = self._child(name)
        if child is None:
            return False
        child.intent = Intent.RESTART
        child.options = options
        if child.running:
            child.terminate()
            asyncio.get_running_loop().call_later(child.spec.grace_s, child.kill)
        self._request.set()
        return True

    def report_end(self, cause: ExitCause, culprit: str, detail: str) -> RunEnd:
        """Print and return the end of a run."""
        self.emit(detail)
        return RunEnd(cause=cause, culprit=culprit, detail=detail)

    def _child(self, name: str) -> ChildProcess | None:
        return next((child for child in self._children if child.spec.name == name), None)

    async def _start(self, spec: ProcessSpec, options: Sequence[str] = ()) -> ChildProcess | RunEnd:
        try:
            child = await ChildProcess.start(spec, self._relay, epoch=self._epochs.next(), options=options)
        except _NO_RESOURCES as error:
            return self.report_end(ExitCause.NOT_STARTED, spec.name, f"{spec.name} cannot be started: {error}")
        child.prioritize_startup()
        child.ended.add_done_callback(partial(self._note_end, child))
        child.on_ready = self._changed
        if child.control is not None and self._on_control is not None:
            self._on_control(spec.name, child.control)
        return child

    async def _until_ready(self, child: ChildProcess) -> RunEnd | None:
        now_s = asyncio.get_running_loop().time
        end_s = now_s() + self._ready_timeout_s
        while not child.ready.is_set() and now_s() < end_s:
            await self._until(child.ready, max(0.0, end_s - now_s()))
            end = await self._mend() or self._end_so_far()
            if end is not None:
                return end
        end = self._end_so_far()
        if end is None and not child.ready.is_set():
            detail = f"{child.spec.name} was not ready within {self._ready_timeout_s:g} s"
            return self.report_end(ExitCause.NOT_READY, child.spec.name, detail)
        return end

    async def _stop_child(self, child: ChildProcess) -> None:
        child.terminate()
        await first_of([self.end_requests.kill.wait()], [child.ended], child.spec.grace_s)
        if child.running:
            child.kill()
            if not self.end_requests.kill.is_set():
                self.emit(f"{child.spec.name} was killed: it did not end in {child.spec.grace_s:g} s")
        await child.ended

    async def _mend(self) -> RunEnd | None:
        """Start others in place of children that have died and may be restarted; return the end if that fails."""
        self._request.clear()
        while (dead := self._restartable(asyncio.get_running_loop().time())) is not None:
            end = await self._restart(dead)
            if end is not None:
                return end
        return None

    def _restartable(self, now_s: float) -> ChildProcess | None:
        """Return a child that has died and may be restarted, unless a signal or another child ends the run."""
        dead = self._dead
        if dead and not self.end_requests.stop.is_set() and all(self._may_restart(child, now_s) for child in dead):
            return dead[0]
        return None

    @property
    def _dead(self) -> list[ChildProcess]:
        """Children that have ended, but for those that are to stay down."""
        return [child for child in self._children if child.ended.done() and child.intent is not Intent.STAY_DOWN]

    def _may_restart(self, child: ChildProcess, now_s: float) -> bool:
        if child.intent is Intent.RESTART:
            return True
        policy = child.spec.restarts
        if policy is None or child in self._starting or child.exit.returncode == 0:
            return False
        recent = sum(now_s - at_s < policy.within_s for at_s in self._restarted_s.get(child.spec.name, ()))
        return recent < policy.most

    async def _restart(self, dead: ChildProcess) -> RunEnd | None:
        """Start another child in place of one that died; return the end of the run if that fails."""
        loop = asyncio.get_running_loop()
        name = dead.spec.name
        child = await self._start(dead.spec, dead.options)
        if isinstance(child, RunEnd):
            return child
        if dead.intent is Intent.RESTART:
            self.emit(f"{name} restarted on request")
        else:
            self.emit(f"{name} died: {dead.exit.description}; restarted")
            self._restarted_s.setdefault(name, []).append(loop.time())
        dead.restarted = True
        self._children[self._children.index(dead)] = child
        self._changed()
        loop.call_later(self._ready_timeout_s, self._kill_unready, child)
        return None

    def _kill_unready(self, child: ChildProcess) -> None:
        if child.running and not child.ready.is_set():
            self.emit(f"{child.spec.name} was not ready within {self._ready_timeout_s:g} s: killed")
            child.kill()

    async def _until(self, wanted: asyncio.Event, timeout_s: float | None) -> None:
        """Wait for ``wanted``, a request or the end of a child, at most ``timeout_s``."""
        wanted_or_requests = [
            event.wait() for event in (wanted, self.end_requests.stop, self.end_requests.interrupt, self._request)
        ]
        ends = [child.ended for child in self._children if child.intent is not Intent.STAY_DOWN]
        await first_of(wanted_or_requests, ends, timeout_s)

    def _note_end(self, child: ChildProcess, _ended: asyncio.Future[int]) -> None:
        self._ended.append(child)
        self._changed()

    def _changed(self) -> None:
        if self._on_change is not None:
            self._on_change()

    def _end_so_far(self) -> RunEnd | None:
        """Return the end of the run if there is one; the end of a child takes precedence over a request."""
        dead = self._dead
        for child in dead:
            if child.spec.restarts is None or child.exit.returncode == 0:
                return self._end_by(child)
        if dead:
            return self._end_by(dead[0])
        return self.end_requests.end

    def _end_by(self, child: ChildProcess) -> RunEnd:
        name, description = child.spec.name, child.exit.description
        if child.exit.returncode == 0:
            return self.report_end(ExitCause.LEFT, name, f"{name} ended: {description}")
        return self.report_end(ExitCause.DIED, name, f"{name} died: {description}")

    def _relay(self, name: str, line: str) -> None:
        self.emit(f"{name:<{self._width}} | {line}")


def _state(child: ChildProcess) -> str:
    if child.intent is Intent.RESTART:
        return "restarting"
    if not child.running:
        return "down"
    return "running" if child.ready.is_set() else "starting"
