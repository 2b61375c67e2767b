"""Starts the processes of a system in order, watches them, and stops them in the opposite order."""

import asyncio
import signal
import sys
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from passafe_services.loop.child_process import Child
from passafe_services.loop.process_exit import Exit, ExitCause, ProcessSpec, RunOutcome

READY_TIMEOUT_S: Final = 20.0
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

Emit = Callable[[str], None]


def supervise(
    specs: Sequence[ProcessSpec],
    *,
    duration_s: float | None = None,
    on_ready: Callable[[], None] | None = None,
    emit: Emit | None = None,
    ready_timeout_s: float = READY_TIMEOUT_S,
) -> RunOutcome:
    """Run processes until one ends, the time is up or somebody asks for the end; main thread only.

    Each process is started when the one before is ready. Once all are, one that dies is started again as often as
    its specification allows, and the others are left alone meanwhile. They are stopped in the opposite order, each
    when the one before has ended: SIGTERM, and SIGKILL after its ``grace_s``. SIGINT, SIGTERM or SIGHUP to this
    process stops them; a second one kills them at once. When this function returns, none is left. When this
    process is killed, their lifelines end.

    Args:
        specs: The processes, in the order in which to start them.
        duration_s: How long to run from the moment when all are ready; ``None``: until something happens.
        on_ready: Called when all are ready.
        emit: Takes each line to print; standard output if not given.
        ready_timeout_s: How long a process may take to be ready; one that was started again and takes longer is
            killed, which counts as its death.

    Returns:
        What ended the run, and how each process ended.
    """
    return asyncio.run(_supervise(specs, duration_s, on_ready, emit or _print, ready_timeout_s))


async def _supervise(
    specs: Sequence[ProcessSpec],
    duration_s: float | None,
    on_ready: Callable[[], None] | None,
    emit: Emit,
    ready_timeout_s: float,
) -> RunOutcome:
    run = _Run(emit, max((len(spec.name) for spec in specs), default=0), ready_timeout_s)
    with run.signals(asyncio.get_running_loop()):
        try:
            end = await run.start(specs)
            if end is None:
                if on_ready is not None:
                    on_ready()
                end = await run.watch(duration_s)
        finally:
            await run.stop_all()
    return RunOutcome(cause=end.cause, culprit=end.culprit, detail=end.detail, exits=run.exits)


@dataclass(frozen=True, kw_only=True, slots=True)
class _End:
    """What ended a run."""

    cause: ExitCause
    culprit: str | None
    detail: str


class _Run:
    """One supervised run."""

    def __init__(self, emit: Emit, width: int, ready_timeout_s: float) -> None:
        self._emit = emit
        self._width = width  # of the longest name
        self._ready_timeout_s = ready_timeout_s
        self._children: list[Child] = []
        self._ended: list[Child] = []
        self._restarted_s: dict[str, list[float]] = {}  # when, by name
        self._stop = asyncio.Event()
        self._kill = asyncio.Event()
        self._signal = ""

    @property
    def exits(self) -> tuple[Exit, ...]:
        """How each process ended, in the order in which they did."""
        return tuple(child.exit for child in self._ended)

    async def start(self, specs: Sequence[ProcessSpec]) -> _End | None:
        """Start each when the one before is ready; returns what kept one from being so."""
        for spec in specs:
            child = await self._start(spec)
            if isinstance(child, _End):
                return child
            self._children.append(child)
            await self._until(child.ready, self._ready_timeout_s)
            end = self._end_so_far()
            if end is not None:
                return end
            if not child.ready.is_set():
                detail = f"{spec.name} was not ready within {self._ready_timeout_s:g} s"
                return self._say_end(ExitCause.NOT_READY, spec.name, detail)
        return None

    async def watch(self, duration_s: float | None) -> _End:
        """Start again what dies and may be, until something ends the run; returns what."""
        now_s = asyncio.get_running_loop().time
        end_s = None if duration_s is None else now_s() + duration_s
        while not self._stop.is_set():
            await self._until(self._stop, None if end_s is None else max(0.0, end_s - now_s()))
            dead = self._restartable(now_s())
            if dead is None:
                break
            end = await self._restart(dead)
            if end is not None:
                return end
        return self._end_so_far() or _End(cause=ExitCause.DURATION, culprit=None, detail=f"{duration_s:g} s are over")

    async def stop_all(self) -> None:
        """Stop them, the last started first; when it returns, all have ended."""
        for child in reversed(self._children):
            child.ask()
            await _first_of([self._kill.wait()], [child.ended], child.spec.grace_s)
            if child.running:
                child.kill()
                if not self._kill.is_set():
                    self._emit(f"{child.spec.name} was killed: it did not end in {child.spec.grace_s:g} s")
            await child.ended

    @contextmanager
    def signals(self, loop: asyncio.AbstractEventLoop) -> Iterator[None]:
        """Take the signals that ask for the end."""
        for signum in _SIGNALS:
            loop.add_signal_handler(signum, self._on_signal, signum)
        try:
            yield
        finally:
            for signum in _SIGNALS:
                loop.remove_signal_handler(signum)

    async def _start(self, spec: ProcessSpec) -> Child | _End:
        try:
            child = await Child.start(spec, self._relay)
        except OSError as error:
            return self._say_end(ExitCause.NOT_STARTED, spec.name, f"{spec.name} cannot be started: {error}")
        child.hurry()
        child.ended.add_done_callback(partial(self._note_end, child))
        return child

    def _restartable(self, now_s: float) -> Child | None:
        """Return a child that has died and may be started again, unless another's end is the end of the run."""
        dead = [child for child in self._children if child.ended.done()]
        if dead and all(child.exit.returncode != 0 and self._may_restart(child.spec, now_s) for child in dead):
            return dead[0]
        return None

    def _may_restart(self, spec: ProcessSpec, now_s: float) -> bool:
        if spec.restarts is None:
            return False
        recent = sum(now_s - at_s < spec.restarts.within_s for at_s in self._restarted_s.get(spec.name, ()))
        return recent < spec.restarts.most

    async def _restart(self, dead: Child) -> _End | None:
        """Put another child in the place of one that died; returns what kept it from being started."""
        loop = asyncio.get_running_loop()
        name = dead.spec.name
        child = await self._start(dead.spec)
        if isinstance(child, _End):
            return child
        self._emit(f"{name} died: {dead.exit.how}; started again")
        dead.restarted = True
        self._restarted_s.setdefault(name, []).append(loop.time())
        self._children[self._children.index(dead)] = child
        loop.call_later(self._ready_timeout_s, self._kill_unready, child)
        return None

    def _kill_unready(self, child: Child) -> None:
        if child.running and not child.ready.is_set():
            self._emit(f"{child.spec.name} was not ready within {self._ready_timeout_s:g} s: killed")
            child.kill()

    async def _until(self, wanted: asyncio.Event, timeout_s: float | None) -> None:
        """Wait for ``wanted``, for a request to stop or for the end of a child, at most ``timeout_s``."""
        await _first_of([wanted.wait(), self._stop.wait()], [child.ended for child in self._children], timeout_s)

    def _note_end(self, child: Child, _ended: asyncio.Future[int]) -> None:
        self._ended.append(child)

    def _end_so_far(self) -> _End | None:
        """Return what has ended the run: a child's end before a request to stop."""
        ended = [child for child in self._children if child.ended.done()]
        for child in ended:
            if child.spec.restarts is None or child.exit.returncode == 0:
                return self._end_by(child)
        if ended:
            return self._end_by(ended[0])
        if self._stop.is_set():
            return _End(cause=ExitCause.SIGNAL, culprit=None, detail=f"stopped by {self._signal}")
        return None

    def _end_by(self, child: Child) -> _End:
        name, how = child.spec.name, child.exit.how
        if child.exit.returncode == 0:
            return self._say_end(ExitCause.LEFT, name, f"{name} ended: {how}")
        return self._say_end(ExitCause.DIED, name, f"{name} died: {how}")

    def _on_signal(self, signum: signal.Signals) -> None:
        if not self._stop.is_set():
            self._signal = signum.name
            self._stop.set()
        else:
            self._kill.set()

    def _say_end(self, cause: ExitCause, culprit: str, detail: str) -> _End:
        self._emit(detail)
        return _End(cause=cause, culprit=culprit, detail=detail)

    def _relay(self, name: str, line: str) -> None:
        self._emit(f"{name:<{self._width}} | {line}")


async def _first_of(
    waits: Iterable[Coroutine[Any, Any, Any]], ends: Iterable[asyncio.Future[int]], timeout_s: float | None
) -> None:
    """Wait until one of them is done, at most ``timeout_s``."""
    tasks = [asyncio.ensure_future(wait) for wait in waits]
    pending: list[asyncio.Future[Any]] = [*tasks, *ends]
    try:
        await asyncio.wait(pending, timeout=timeout_s, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()


def _print(line: str) -> None:
    with suppress(OSError):  # nobody is left to read it; the processes still have to be stopped
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
