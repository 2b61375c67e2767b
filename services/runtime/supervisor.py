"""Starts the processes of a system in order, watches them, and stops them in the opposite order."""

import asyncio
import signal
import sys
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from services.runtime.child import Child
from services.runtime.outcome import Cause, Exit, Outcome, ProcessSpec

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
) -> Outcome:
    """Run processes until one ends, the time is up or somebody asks for the end; main thread only.

    Each process is started when the one before is ready. They are stopped in the opposite order, each when
    the one before has ended: SIGTERM, and SIGKILL after its ``grace_s``. SIGINT, SIGTERM or SIGHUP to this
    process stops them; a second one kills them at once. When this function returns, none is left. When this
    process is killed, their lifelines end.

    Args:
        specs: The processes, in the order in which to start them.
        duration_s: How long to run from the moment when all are ready; ``None``: until something happens.
        on_ready: Called when all are ready.
        emit: Takes each line to print; standard output if not given.
        ready_timeout_s: How long a process may take to be ready.

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
) -> Outcome:
    run = _Run(emit, max((len(spec.name) for spec in specs), default=0))
    with run.signals(asyncio.get_running_loop()):
        try:
            end = await run.start(specs, ready_timeout_s)
            if end is None:
                if on_ready is not None:
                    on_ready()
                end = await run.watch(duration_s)
        finally:
            await run.stop_all()
    return Outcome(cause=end.cause, culprit=end.culprit, detail=end.detail, exits=run.exits)


@dataclass(frozen=True, kw_only=True, slots=True)
class _End:
    """What ended a run."""

    cause: Cause
    culprit: str | None
    detail: str


class _Run:
    """One supervised run."""

    def __init__(self, emit: Emit, width: int) -> None:
        self._emit = emit
        self._width = width  # of the longest name
        self._children: list[Child] = []
        self._ended: list[Child] = []
        self._stop = asyncio.Event()
        self._kill = asyncio.Event()
        self._signal = ""

    @property
    def exits(self) -> tuple[Exit, ...]:
        """How each process ended, in the order in which they did."""
        return tuple(child.exit for child in self._ended)

    async def start(self, specs: Sequence[ProcessSpec], ready_timeout_s: float) -> _End | None:
        """Start each when the one before is ready; returns what kept one from being so."""
        for spec in specs:
            try:
                child = await Child.start(spec, self._relay)
            except OSError as error:
                detail = f"{spec.name} cannot be started: {error}"
                return self._say_end(Cause.NOT_STARTED, spec.name, detail)
            self._children.append(child)
            child.ended.add_done_callback(partial(self._note_end, child))
            end = await self._until(child.ready, ready_timeout_s)
            if end is not None:
                return end
            if not child.ready.is_set():
                detail = f"{spec.name} was not ready within {ready_timeout_s:g} s"
                return self._say_end(Cause.NOT_READY, spec.name, detail)
        return None

    async def watch(self, duration_s: float | None) -> _End:
        """Wait until something ends the run; returns what."""
        end = await self._until(self._stop, duration_s)
        return end or _End(cause=Cause.DURATION, culprit=None, detail=f"{duration_s:g} s are over")

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

    async def _until(self, wanted: asyncio.Event, timeout_s: float | None) -> _End | None:
        """Wait for ``wanted``, at most ``timeout_s``; returns what ended the run in the meantime."""
        await _first_of([wanted.wait(), self._stop.wait()], [child.ended for child in self._children], timeout_s)
        for child in self._children:
            if child.ended.done():
                return self._end_by(child)
        if self._stop.is_set():
            return _End(cause=Cause.SIGNAL, culprit=None, detail=f"stopped by {self._signal}")
        return None

    def _note_end(self, child: Child, _ended: asyncio.Future[int]) -> None:
        self._ended.append(child)

    def _end_by(self, child: Child) -> _End:
        name, how = child.spec.name, child.exit.how
        if child.exit.returncode == 0:
            return self._say_end(Cause.LEFT, name, f"{name} ended: {how}")
        return self._say_end(Cause.DIED, name, f"{name} died: {how}")

    def _on_signal(self, signum: signal.Signals) -> None:
        if not self._stop.is_set():
            self._signal = signum.name
            self._stop.set()
        else:
            self._kill.set()

    def _say_end(self, cause: Cause, culprit: str, detail: str) -> _End:
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
