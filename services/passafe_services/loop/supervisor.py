"""Starts the processes of a system in order, restarts those that die, and stops them in reverse order."""

import asyncio
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import Final

from passafe_services.loop.child_process import ChildProcess
from passafe_services.loop.first_of import first_of
from passafe_services.loop.process_exit import Exit, ExitCause, RunOutcome
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.session_epochs import SessionEpochs

READY_TIMEOUT_S: Final = 20.0
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_NO_RESOURCES: Final = (OSError, RuntimeError, MemoryError)
"""No program, file descriptor or process; no thread; no memory."""

PrintLine = Callable[[str], None]


def supervise(
    specs: Sequence[ProcessSpec],
    *,
    duration_s: float | None = None,
    on_ready: Callable[[], None] | None = None,
    emit: PrintLine | None = None,
    ready_timeout_s: float = READY_TIMEOUT_S,
    epochs: SessionEpochs | None = None,
) -> RunOutcome:
    """Run processes until one ends, the duration is over or a signal requests the end; main thread only.

    Each process is started when the previous one is ready. Once all are ready, one that dies is restarted as often as
    its restart policy allows, while the others keep running. They are stopped in reverse order, one after the other:
    SIGTERM, and SIGKILL after ``grace_s``. SIGINT, SIGTERM or SIGHUP to this process stops them; a second signal kills
    them at once. When this function returns, none is left. If this process is killed, their lifelines close.

    Args:
        specs: The processes, in the order of their start.
        duration_s: Duration of the run from the time at which all are ready, s; ``None``: no limit.
        on_ready: Called when all are ready.
        emit: Called with each line to print; standard output if not given.
        ready_timeout_s: Time that a process may take to be ready, s; a restarted one that takes longer is killed,
            which counts as its death.
        epochs: Epochs of the sessions; from the wall clock if not given.

    Returns:
        Cause of the end and exit of each process.
    """
    if sys.platform == "linux" and sys.version_info < (3, 12):  # later ones do so by themselves
        asyncio.set_child_watcher(asyncio.PidfdChildWatcher())  # no thread for each process: each takes address space
    width = max((len(spec.name) for spec in specs), default=0)
    run = _Run(emit or _print, width, ready_timeout_s, epochs or SessionEpochs())
    return asyncio.run(_supervise(specs, duration_s, on_ready, run))


async def _supervise(
    specs: Sequence[ProcessSpec], duration_s: float | None, on_ready: Callable[[], None] | None, run: "_Run"
) -> RunOutcome:
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
    """End of a run and its cause."""

    cause: ExitCause
    culprit: str | None
    detail: str


class _Run:
    """One supervised run."""

    def __init__(self, emit: PrintLine, width: int, ready_timeout_s: float, epochs: SessionEpochs) -> None:
        self._emit = emit
        self._width = width  # of the longest name
        self._ready_timeout_s = ready_timeout_s
        self._epochs = epochs
        self._children: list[ChildProcess] = []
        self._ended: list[ChildProcess] = []
        self._restarted_s: dict[str, list[float]] = {}  # times of restarts by name
        self._stop = asyncio.Event()
        self._kill = asyncio.Event()
        self._signal = ""

    @property
    def exits(self) -> tuple[Exit, ...]:
        """Exit of each process, in the order in which they ended."""
        return tuple(child.exit for child in self._ended)

    async def start(self, specs: Sequence[ProcessSpec]) -> _End | None:
        """Start each process when the previous one is ready; return the end of the run if one fails."""
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
                return self._report_end(ExitCause.NOT_READY, spec.name, detail)
        return None

    async def watch(self, duration_s: float | None) -> _End:
        """Restart processes that die, as their policies allow, until the run ends."""
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
        """Stop the processes, the last started first, and wait until all have ended."""
        for child in reversed(self._children):
            child.terminate()
            await first_of([self._kill.wait()], [child.ended], child.spec.grace_s)
            if child.running:
                child.kill()
                if not self._kill.is_set():
                    self._emit(f"{child.spec.name} was killed: it did not end in {child.spec.grace_s:g} s")
            await child.ended

    @contextmanager
    def signals(self, loop: asyncio.AbstractEventLoop) -> Iterator[None]:
        """Handle the signals that request the end."""
        for signum in _SIGNALS:
            loop.add_signal_handler(signum, self._on_signal, signum)
        try:
            yield
        finally:
            for signum in _SIGNALS:
                loop.remove_signal_handler(signum)

    async def _start(self, spec: ProcessSpec) -> ChildProcess | _End:
        try:
            child = await ChildProcess.start(spec, self._relay, epoch=self._epochs.next())
        except _NO_RESOURCES as error:
            return self._report_end(ExitCause.NOT_STARTED, spec.name, f"{spec.name} cannot be started: {error}")
        child.prioritize_startup()
        child.ended.add_done_callback(partial(self._note_end, child))
        return child

    def _restartable(self, now_s: float) -> ChildProcess | None:
        """Return a child that has died and may be restarted, unless another one ends the run."""
        dead = [child for child in self._children if child.ended.done()]
        if dead and all(child.exit.returncode != 0 and self._may_restart(child.spec, now_s) for child in dead):
            return dead[0]
        return None

    def _may_restart(self, spec: ProcessSpec, now_s: float) -> bool:
        if spec.restarts is None:
            return False
        recent = sum(now_s - at_s < spec.restarts.within_s for at_s in self._restarted_s.get(spec.name, ()))
        return recent < spec.restarts.most

    async def _restart(self, dead: ChildProcess) -> _End | None:
        """Start another child in place of one that died; return the end of the run if that fails."""
        loop = asyncio.get_running_loop()
        name = dead.spec.name
        child = await self._start(dead.spec)
        if isinstance(child, _End):
            return child
        self._emit(f"{name} died: {dead.exit.description}; restarted")
        dead.restarted = True
        self._restarted_s.setdefault(name, []).append(loop.time())
        self._children[self._children.index(dead)] = child
        loop.call_later(self._ready_timeout_s, self._kill_unready, child)
        return None

    def _kill_unready(self, child: ChildProcess) -> None:
        if child.running and not child.ready.is_set():
            self._emit(f"{child.spec.name} was not ready within {self._ready_timeout_s:g} s: killed")
            child.kill()

    async def _until(self, wanted: asyncio.Event, timeout_s: float | None) -> None:
        """Wait for ``wanted``, a stop request or the end of a child, at most ``timeout_s``."""
        await first_of([wanted.wait(), self._stop.wait()], [child.ended for child in self._children], timeout_s)

    def _note_end(self, child: ChildProcess, _ended: asyncio.Future[int]) -> None:
        self._ended.append(child)

    def _end_so_far(self) -> _End | None:
        """Return the end of the run if there is one; the end of a child takes precedence over a stop request."""
        ended = [child for child in self._children if child.ended.done()]
        for child in ended:
            if child.spec.restarts is None or child.exit.returncode == 0:
                return self._end_by(child)
        if ended:
            return self._end_by(ended[0])
        if self._stop.is_set():
            return _End(cause=ExitCause.SIGNAL, culprit=None, detail=f"stopped by {self._signal}")
        return None

    def _end_by(self, child: ChildProcess) -> _End:
        name, description = child.spec.name, child.exit.description
        if child.exit.returncode == 0:
            return self._report_end(ExitCause.LEFT, name, f"{name} ended: {description}")
        return self._report_end(ExitCause.DIED, name, f"{name} died: {description}")

    def _on_signal(self, signum: signal.Signals) -> None:
        if not self._stop.is_set():
            self._signal = signum.name
            self._stop.set()
        else:
            self._kill.set()

    def _report_end(self, cause: ExitCause, culprit: str, detail: str) -> _End:
        self._emit(detail)
        return _End(cause=cause, culprit=culprit, detail=detail)

    def _relay(self, name: str, line: str) -> None:
        self._emit(f"{name:<{self._width}} | {line}")


def _print(line: str) -> None:
    with suppress(OSError):  # standard output may be closed; the processes still have to be stopped
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
