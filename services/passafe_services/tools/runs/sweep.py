"""The runs of a plan, chunk by chunk, until it wants no more."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, Generic, Protocol, TypeVar

from passafe_services.tools.runs.errors import WorkerLostError
from passafe_services.tools.runs.workers import Workers

Task = TypeVar("Task")
Task_co = TypeVar("Task_co", covariant=True)
R = TypeVar("R")
R_contra = TypeVar("R_contra", contravariant=True)

LOOK_S: Final = 0.2
"""Period of the check for a request to stop, s."""


class SweepPlan(Protocol[Task_co, R_contra]):
    """Decides which tasks a sweep consists of."""

    def first(self) -> Iterable[Task_co]:
        """Return the tasks that are wanted from the start."""
        ...

    def after(self, result: R_contra) -> Sequence[Task_co]:
        """Return the tasks that are wanted because of a result."""
        ...


class FixedPlan(Generic[Task]):
    """Wants the same tasks whatever their results are."""

    def __init__(self, tasks: Iterable[Task]) -> None:
        """Keep the tasks."""
        self._tasks = tuple(tasks)

    def first(self) -> Sequence[Task]:
        """Return all tasks."""
        return self._tasks

    def after(self, _result: object) -> Sequence[Task]:
        """Return no task."""
        return ()


def sweep(
    plan: SweepPlan[Task, R],
    workers: Workers[Task, R],
    chunk_size: Callable[[int], int],
    stop: Callable[[], bool] = lambda: False,
) -> Iterator[list[R]]:
    """Yield the results of every task that a plan wants, chunk by chunk as they come.

    Args:
        plan: What is wanted.
        workers: Who does it.
        chunk_size: From the number of tasks that wait to how many of them the next chunk has, at most.
        stop: Whether to end at once; chunks in work are lost.

    Raises:
        WorkerLostError: A worker process died.
    """
    waiting = deque(plan.first())
    try:
        while not stop() and (waiting or workers.busy):
            while waiting and workers.free:
                size = min(chunk_size(len(waiting)), len(waiting))
                workers.submit([waiting.popleft() for _ in range(size)])
            for results in workers.completed(LOOK_S):
                for result in results:
                    waiting.extend(plan.after(result))
                yield results
    except WorkerLostError:
        if not stop():  # a signal to the whole group of processes reaches workers too
            raise
