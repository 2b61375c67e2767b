"""Epochs of the sessions that one supervisor starts: no two are equal, whatever the wall clock does."""

import time
from collections.abc import Callable


class SessionEpochs:
    """Gives every process an epoch larger than that of every process started before it.

    An epoch is the wall clock's time, so that no earlier run had it; but a clock that was set back could give it twice.
    Readers do not order sessions by their epochs.
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
