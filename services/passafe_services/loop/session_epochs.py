"""Epochs of the sessions that one supervisor starts: they grow whatever the wall clock does."""

import time
from collections.abc import Callable


class SessionEpochs:
    """Gives every process an epoch larger than that of every process started before it.

    An epoch is the wall clock's time, so that it is larger than those of earlier runs; but a clock that was set back,
    or that was ahead when an earlier process started, must not lock a restarted process out.
    """

    def __init__(self, wall_ns: Callable[[], int] = time.time_ns) -> None:
        """Start before the first process.

        Args:
            wall_ns: Wall clock, Unix time, ns.
        """
        self._wall_ns = wall_ns
        self._newest = 0

    def next(self) -> int:
        """Return the epoch of the next process."""
        self._newest = max(self._wall_ns(), self._newest + 1)
        return self._newest
