"""Workers of a Dask cluster."""

import socket
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import contextmanager
from typing import Final, Generic, TypeVar

from passafe_services.scenarios.info import versions
from passafe_services.tools.runs.errors import SchedulerError, WorkerLostError
from passafe_services.tools.runs.job import Job, run_chunk

Task = TypeVar("Task")
R = TypeVar("R")

SCHEDULER_TIMEOUT_S: Final = 10

AHEAD: Final = 2
"""Chunks for each worker, in work or waiting, so that it need not wait for this process."""


@contextmanager
def dask_workers(job: Job[Task, R], address: str) -> Iterator["DaskWorkers[Task, R]"]:
    """Connect to the workers of a cluster. Each must have this version of passafe and of what it computes with.

    Args:
        job: What they work for.
        address: Of the cluster's scheduler, such as ``tcp://127.0.0.1:8786``.

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
        # A client that finds nobody keeps trying in the background, and complains when the process ends.
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
            yield DaskWorkers(job, client.get_executor(pure=False), len(there))
        except KilledWorker as error:
            raise WorkerLostError from error


class DaskWorkers(Generic[Task, R]):
    """Workers of a cluster that work for one job.

    Attributes:
        count: How many there are.
    """

    def __init__(self, job: Job[Task, R], executor: Executor, count: int) -> None:
        """Start with nothing submitted.

        Args:
            job: What they work for.
            executor: The cluster's.
            count: How many chunks it works at together.
        """
        self.count = count
        self._job = job
        self._executor = executor
        self._submitted: set[Future[list[R]]] = set()

    @property
    def free(self) -> int:
        """Number of chunks that they accept now."""
        return AHEAD * self.count - self.busy

    @property
    def busy(self) -> int:
        """Number of chunks in work or waiting for a worker."""
        return len(self._submitted)

    def submit(self, tasks: Sequence[Task]) -> None:
        """Give the cluster a chunk."""
        self._submitted.add(self._executor.submit(run_chunk, self._job, list(tasks)))

    def completed(self, timeout_s: float) -> list[list[R]]:
        """Wait for the results of at least one chunk, or for ``timeout_s``; return those that have come."""
        done, self._submitted = wait(self._submitted, timeout=timeout_s, return_when=FIRST_COMPLETED)
        return [future.result() for future in done]
