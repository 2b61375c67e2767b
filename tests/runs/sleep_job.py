"""A job for tests of workers: every task sleeps, then returns some bytes, raises, or kills its process."""

import os
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple


class Task(NamedTuple):
    """One task.

    Attributes:
        sleep_s: How long it takes, s.
        size: Bytes of its result; −1: it raises; −2: it kills its process.
    """

    sleep_s: float = 0.0
    size: int = 1


class TwoArgumentsError(Exception):
    """An error whose constructor does not take the arguments that it keeps."""

    def __init__(self, first: str, second: str) -> None:
        self.second = second
        super().__init__(f"{first} and {second}")


@dataclass(frozen=True, kw_only=True, slots=True)
class SleepJob:
    """Sleeps."""

    def compile(self) -> Callable[[Sequence[Task]], list[tuple[int, bytes]]]:
        """Return the function from tasks to their process and bytes."""
        return lambda tasks: [done(task) for task in tasks]


def done(task: Task) -> tuple[int, bytes]:
    """Do one task."""
    time.sleep(task.sleep_s)
    if task.size == -1:
        raise TwoArgumentsError("one", "two")
    if task.size == -2:
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid(), bytes(task.size)
