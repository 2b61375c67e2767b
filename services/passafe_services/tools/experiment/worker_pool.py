"""Runs of a study in worker processes: of this machine, or of a Dask cluster."""

import os
import signal
import socket
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing import connection, get_context, parent_process
from threading import Lock, Thread
from typing import Any, Final, TypeVar

from passafe_services.scenarios.info import versions
from passafe_services.tools.experiment.errors import SchedulerError, WorkerLostError
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.experiment.runs import Result, Run

R = TypeVar("R")

SCHEDULER_TIMEOUT_S: Final = 10

LOOK_S: Final = 0.2
"""How often somebody's wish to stop is looked for."""

AHEAD: Final = 2
"""Portions for each worker, in work or waiting, so that it need not wait for this process."""

PORTION: Final = 4
"""Runs that a worker takes at a time, at most; they share what is derived and their reference."""

LEAST_PORTIONS: Final = 8
"""Portions for each worker that there should be, so that all of them end at about the same time."""

_one_at_a_time = Lock()


@dataclass(frozen=True, kw_only=True)
class WorkerPool:
    """Who does the work.

    Attributes:
        executor: Takes portions.
        workers: How many it does at the same time.
        ahead: Portions to give out for each worker.
        portion: Runs in a portion, at most.
        takes_back: Whether a portion that is cancelled is one that nobody works at.
    """

    executor: Executor
    workers: int
    ahead: int = AHEAD
    portion: int = PORTION
    takes_back: bool = True


def results(plan: Plan, study: Study, crew: WorkerPool, stop: Callable[[], bool]) -> Iterator[Result]:
    """Yield the result of every run that a plan wants, as they come.

    Args:
        plan: What is wanted; takes in every result.
        study: Whose runs they are.
        crew: Who runs them.
        stop: Whether to begin nothing more; what is in work is still waited for.

    Raises:
        WorkerLostError: A worker process died.
    """
    waiting = deque(plan.first())
    flying: set[Future[list[Result]]] = set()
    try:
        while flying or (waiting and not stop()):
            while waiting and len(flying) < crew.ahead * crew.workers and not stop():
                size = min(crew.portion, -(-len(waiting) // (LEAST_PORTIONS * crew.workers)))
                portion = [waiting.popleft() for _ in range(size)]
                flying.add(crew.executor.submit(run_chunk, study, portion))
            if stop() and crew.takes_back:
                flying -= {future for future in flying if future.cancel()}
            done, flying = wait(flying, timeout=LOOK_S, return_when=FIRST_COMPLETED)
            for future in done:
                for result in future.result():
                    waiting.extend(plan.after(result))
                    yield result
    except BrokenExecutor as error:
        raise WorkerLostError from error


def run_chunk(study: Study, runs: Sequence[Run]) -> list[Result]:
    """Return the results of some runs, in their order.

    A process keeps what it derived for the study that it last worked for. Threads of one process take turns.
    """
    with _one_at_a_time:
        bench = _bench(study.model_dump_json())
        return [bench.result(run) for run in runs]


@lru_cache(maxsize=1)
def _bench(study_json: str) -> StudyRunner:
    return StudyRunner(Study.model_validate_json(study_json))


@contextmanager
def local_processes(workers: int) -> Iterator[WorkerPool]:
    """Give worker processes of this machine; with one, everything happens in this process."""
    if workers == 1:
        yield WorkerPool(executor=InThisProcess(), workers=1, ahead=1, portion=1)
        return
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_live_and_die_with_the_parent)
    try:
        yield WorkerPool(executor=pool, workers=workers)
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def dask_cluster(address: str) -> Iterator[WorkerPool]:
    """Give the workers of a Dask cluster. Each must have this version of passafe and of what it computes with.

    Args:
        address: Of its scheduler, such as ``tcp://127.0.0.1:8786``.

    Raises:
        SchedulerError: Dask is not installed, there is no scheduler at that address, or its workers do not serve.
        WorkerLostError: Workers died, one after the other, over the same runs.
    """
    try:
        from distributed import Client, KilledWorker  # noqa: PLC0415 - an extra that only this needs
        from distributed.comm.addressing import get_address_host_port  # noqa: PLC0415 - likewise
    except ImportError as error:
        raise SchedulerError(address, "no Dask here", "pip install 'passafe[dask]'") from error
    try:
        # A client that finds nobody goes on trying in the background, and complains when the process ends.
        socket.create_connection(get_address_host_port(address, strict=True), SCHEDULER_TIMEOUT_S).close()
        client = Client(address, timeout=SCHEDULER_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise SchedulerError(address, str(error), "the address of a running Dask scheduler") from error
    with client:
        there = client.run(versions)
        if not there:
            raise SchedulerError(address, "no workers", "a cluster with at least one: dask worker ADDRESS")
        for worker, its_versions in there.items():
            if its_versions != versions():
                raise SchedulerError(address, f"{worker} with {its_versions}", f"workers with {versions()}")
        try:
            yield WorkerPool(executor=client.get_executor(pure=False), workers=len(there), portion=2, takes_back=False)
        except KilledWorker as error:
            raise WorkerLostError from error


class InThisProcess(Executor):
    """Runs at once what it is given."""

    def submit(self, fn: Callable[..., R], /, *args: Any, **kwargs: Any) -> Future[R]:  # noqa: ANN401 - as the base class has it
        """Return what a call gives, as a future that is done."""
        future: Future[R] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def _live_and_die_with_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which waits for what is in work
    parent = parent_process()
    if parent is not None:
        Thread(target=_die_after, args=(parent.sentinel,), name="parent", daemon=True).start()


def _die_after(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
