"""The work of a sweep as a worker receives it: compiled once in every process, then run chunk by chunk."""

from collections.abc import Callable, Hashable, Sequence
from functools import lru_cache
from threading import Lock
from typing import Any, Protocol, TypeVar

Task_contra = TypeVar("Task_contra", contravariant=True)
Task = TypeVar("Task")
R = TypeVar("R")

_one_at_a_time = Lock()


class Job(Hashable, Protocol[Task_contra, R]):
    """The part that all tasks of a sweep have in common; it can be pickled, and equal ones are the same work."""

    def compile(self) -> Callable[[Sequence[Task_contra]], list[R]]:
        """Return the function from tasks to their results, in the same order."""
        ...


def run_chunk(job: Job[Task, R], tasks: Sequence[Task]) -> list[R]:
    """Return the results of some tasks, in their order.

    A process keeps what it compiled for the job that it worked for last. Threads of one process take turns.
    """
    with _one_at_a_time:
        return list(_compiled(job)(tasks))


@lru_cache(maxsize=1)
def _compiled(job: Job[Any, R]) -> Callable[[Sequence[Any]], list[R]]:
    return job.compile()
