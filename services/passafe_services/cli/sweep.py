"""Starts workers and handles Ctrl-C for the commands of many runs."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TypeVar

import typer
from rich.console import Console

from passafe_services.cli.failure import INTERRUPTED
from passafe_services.loop.realtime import available_processors
from passafe_services.loop.stop import Stop
from passafe_services.tools.runs.dask_workers import dask_workers
from passafe_services.tools.runs.job import Job
from passafe_services.tools.runs.worker_processes import WorkerProcesses
from passafe_services.tools.runs.workers import Workers

Task = TypeVar("Task")
R = TypeVar("R")


@contextmanager
def workers_for(
    job: Job[Task, R], workers: int, tasks: int, scheduler: str | None = None
) -> Iterator[Workers[Task, R]]:
    """Yield the workers that the options ask for; processes of this machine are killed at the end.

    Args:
        job: The work.
        workers: Number of processes; 0: one for each processor.
        tasks: Number of tasks, at most: no more processes than that are started.
        scheduler: Address of a Dask scheduler whose cluster does the work instead.
    """
    if scheduler is not None:
        with dask_workers(job, scheduler) as cluster:
            yield cluster
    else:
        with closing(WorkerProcesses(job, min(workers or available_processors(), tasks))) as processes:
            yield processes


def exit_if_interrupted(stop: Stop, results: int, folder: Path, console: Console) -> None:
    """End the command if Ctrl-C was pressed.

    Args:
        stop: The requests to stop.
        results: Number of results so far.
        folder: Where they are.
        console: Where the interruption is reported.
    """
    if stop.reason is not None:
        console.print(f"interrupted after {results} runs; the same command resumes in {folder}")
        raise typer.Exit(INTERRUPTED)
