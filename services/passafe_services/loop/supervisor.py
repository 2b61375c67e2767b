"""Starts the processes of a system in order, restarts those that die, and stops them in reverse order."""

import asyncio
import socket
import sys
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Final, TypeVar

from passafe_services.loop.process_exit import RunEnd, RunOutcome
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.session_epochs import SessionEpochs
from passafe_services.loop.supervision import PrintLine, Supervision

READY_TIMEOUT_S: Final = 20.0

Result = TypeVar("Result")


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

    async def start_and_watch(supervision: Supervision) -> tuple[RunEnd, Supervision]:
        end = await supervision.start(specs)
        if end is None:
            if on_ready is not None:
                on_ready()
            end = await supervision.watch(duration_s)
        return end, supervision

    end, supervision = supervised(start_and_watch, emit=emit, ready_timeout_s=ready_timeout_s, epochs=epochs)
    return RunOutcome.of(end, supervision.take_exits())


def supervised(
    body: Callable[[Supervision], Awaitable[Result]],
    *,
    emit: PrintLine | None = None,
    ready_timeout_s: float = READY_TIMEOUT_S,
    epochs: SessionEpochs | None = None,
    on_change: Callable[[], None] | None = None,
    on_control: Callable[[str, socket.socket], None] | None = None,
) -> Result:
    """Return what ``body`` returns, which starts and watches processes; when it does, none of them is left.

    Args:
        body: Called with the supervision; SIGINT, SIGTERM and SIGHUP end its waits, a second signal kills.
        emit: Called with each line to print; standard output if not given.
        ready_timeout_s: Time that a process may take to be ready, s.
        epochs: Epochs of the sessions; from the wall clock if not given.
        on_change: See ``Supervision``.
        on_control: See ``Supervision``.
    """

    async def run() -> Result:
        supervision = Supervision(
            emit or _print,
            ready_timeout_s=ready_timeout_s,
            epochs=epochs or SessionEpochs(),
            on_change=on_change,
            on_control=on_control,
        )
        with supervision.end_requests.signals(asyncio.get_running_loop()):
            try:
                return await body(supervision)
            finally:
                await supervision.stop()

    with _no_thread_for_each_process():
        return asyncio.run(run())


@contextmanager
def _no_thread_for_each_process() -> Iterator[None]:
    """Let asyncio wait for processes without a thread for each, which takes address space; since 3.12 it does."""
    if sys.platform == "linux" and sys.version_info < (3, 12):
        asyncio.set_child_watcher(asyncio.PidfdChildWatcher())
        try:
            yield
        finally:
            asyncio.set_child_watcher(None)  # type: ignore[arg-type]  # documented: the default again, not one without a loop
    else:
        yield


def _print(line: str) -> None:
    with suppress(OSError):  # standard output may be closed; the processes still have to be stopped
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
