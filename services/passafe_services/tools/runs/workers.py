"""Workers as a sweep sees them: processes of this machine, or a cluster's."""

from collections.abc import Sequence
from typing import Protocol, TypeVar

Task_contra = TypeVar("Task_contra", contravariant=True)
R = TypeVar("R")


class Workers(Protocol[Task_contra, R]):
    """Processes that work for one job.

    Attributes:
        count: How many there are.
    """

    count: int

    @property
    def free(self) -> int:
        """Number of chunks that they accept now."""
        ...

    @property
    def busy(self) -> int:
        """Number of chunks that they have accepted and whose results were not returned yet."""
        ...

    def submit(self, tasks: Sequence[Task_contra]) -> None:
        """Give them one chunk; only while some are free.

        Raises:
            WorkerLostError: A worker process died.
        """
        ...

    def completed(self, timeout_s: float) -> list[list[R]]:
        """Wait for the results of at least one chunk, or for ``timeout_s``; return those that have come.

        Raises:
            WorkerLostError: A worker process died.
        """
        ...
