"""Worker processes of this machine, each at the end of a pipe of its own.

A process that is killed may leave behind a lock that it held, or half a message: whoever shares a queue with it then
waits for ever, as pools with one queue for all results do. Here nothing is shared. A dead worker is the end of its
pipe, which wakes the parent at once, in the middle of a message too (``docs/decisions/0017-one-pipe-per-worker.md``).
"""

import os
import signal
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import connection, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from threading import Thread
from typing import Any, Generic, TypeVar

from threadpoolctl import threadpool_limits

from passafe_services.tools.runs.errors import WorkerLostError
from passafe_services.tools.runs.job import Job, run_chunk

Task = TypeVar("Task")
R = TypeVar("R")


class WorkerProcesses(Generic[Task, R]):
    """Processes of this machine that work for one job; each ends when its parent does, however that happens.

    ``contextlib.closing`` kills them at the end of a block, whatever they are doing.

    Attributes:
        count: How many there are.
        processes: The processes.
    """

    def __init__(self, job: Job[Task, R], count: int) -> None:
        """Start the processes.

        Args:
            job: What they work for.
            count: How many.
        """
        self.count = count
        self.processes: list[SpawnProcess] = []
        self._idle: list[Connection] = []
        self._busy: list[Connection] = []
        try:
            self._start_all()
            for pipe in self._idle:
                _send(pipe, job)
        except BaseException:
            self.close()
            raise

    @property
    def free(self) -> int:
        """Number of chunks that they accept now: one for each idle process."""
        return len(self._idle)

    @property
    def busy(self) -> int:
        """Number of chunks in work."""
        return len(self._busy)

    def submit(self, tasks: Sequence[Task]) -> None:
        """Give a chunk to an idle process.

        Raises:
            WorkerLostError: That process died.
        """
        pipe = self._idle.pop()
        self._busy.append(pipe)
        _send(pipe, list(tasks))

    def completed(self, timeout_s: float) -> list[list[R]]:
        """Wait for the results of at least one chunk, or for ``timeout_s``; return those that have come.

        Raises:
            WorkerLostError: A process died, at work or idle.
            Exception: What a task raised.
        """
        found: list[list[R]] = []
        pipes = (*self._busy, *self._idle)
        ready = connection.wait(pipes, timeout_s)
        for pipe in pipes:
            if pipe not in ready:
                continue
            try:
                outcome = pipe.recv()
            except (EOFError, OSError) as error:
                raise WorkerLostError from error
            if isinstance(outcome, _Failure):
                raise outcome.error()
            self._busy.remove(pipe)
            self._idle.append(pipe)
            found.append(outcome)
        return found

    def close(self) -> None:
        """Kill every process that is left."""
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.join()
        for pipe in (*self._idle, *self._busy):
            pipe.close()

    def _start_all(self) -> None:
        resource_tracker.ensure_running()  # or it would be started, and unblock the signal, further down
        # Ctrl-C is for the parent: a process inherits the blocked signal, so that none interrupts its imports either.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            for _ in range(self.count):
                self._start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def _start(self) -> None:
        context = get_context("spawn")
        own_end, its_end = context.Pipe()
        # The job is not an argument: a process that dies while it starts would leave the parent writing for ever.
        process = context.Process(target=_work, args=(its_end,), daemon=True)
        self._idle.append(own_end)
        process.start()
        self.processes.append(process)
        its_end.close()  # the process has the only one left: when it dies, the pipe ends


def _send(pipe: Connection, message: object) -> None:
    try:
        pipe.send(message)
    except OSError as error:
        raise WorkerLostError from error


@dataclass(frozen=True, kw_only=True, slots=True)
class _Failure:
    """An error of a worker, for its parent to raise: made again without its constructor, whatever that asks for."""

    kind: type[Exception]
    arguments: tuple[Any, ...]
    attributes: dict[str, Any]

    @classmethod
    def of(cls, error: Exception) -> "_Failure":
        """Return what is sent of an error, its traceback as a note."""
        error.add_note("".join(traceback.format_exception(error)))
        return cls(kind=type(error), arguments=error.args, attributes=vars(error))

    def error(self) -> Exception:
        """Return the error."""
        error = self.kind.__new__(self.kind, *self.arguments)
        vars(error).update(self.attributes)
        return error


def _work(pipe: Connection) -> None:
    """Work until the parent closes the pipe."""
    parent = parent_process()
    if parent is not None:
        Thread(target=_end_after, args=(parent.sentinel,), name="parent", daemon=True).start()
    job = pipe.recv()  # which imports what has threads
    with threadpool_limits(1):  # as many processes as cores: threads of theirs would only wait for one another
        while True:
            try:
                tasks = pipe.recv()
            except EOFError:
                return
            outcome: object
            try:
                outcome = run_chunk(job, tasks)
            except Exception as error:  # noqa: BLE001 - for the parent to raise, whatever it is
                outcome = _Failure.of(error)
            pipe.send(outcome)


def _end_after(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
