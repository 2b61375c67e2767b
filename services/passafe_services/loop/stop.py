"""Stop requests of a process: a signal, or the end of its lifeline.

A lifeline is a standard input that the parent holds open. It closes when the parent ends, even if it is killed, so a
supervised process never outlives its supervisor.
"""

import os
import select
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from types import FrameType
from typing import Final

LIFELINE_GRACE_S: Final = 5.0
"""Time after the end of its lifeline at which a process is killed."""

_STANDARD_INPUT: Final = 0
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


class StopReason(Enum):
    """Reason for which a process stopped."""

    SIGNAL = "signal"
    LIFELINE = "end of the lifeline"
    DURATION = "end of its duration"
    FINISHED = "its own decision"


class Stop:
    """Stop request; created by ``stop_requests``.

    It wakes a waiter through a pipe: a lock could be held by the code that the signal handler interrupts. The pipe is
    never closed, since the lifeline's thread may write to it until the process ends.

    Attributes:
        reason: Reason to stop; ``None`` before a request.
    """

    def __init__(self) -> None:
        self.reason: StopReason | None = None
        self._read_end, self._write_end = os.pipe()

    def request(self, reason: StopReason) -> None:
        """Request a stop; the first reason is kept."""
        if self.reason is None:
            self.reason = reason
            os.write(self._write_end, b"\0")

    def is_requested(self) -> bool:
        """Return whether somebody asked to stop."""
        return self.reason is not None

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for a stop request, at most ``timeout_s``; return whether there was one."""
        select.select([self._read_end], [], [], timeout_s)
        return self.reason is not None


@contextmanager
def stop_requests(*, lifeline: bool) -> Iterator[Stop]:
    """Turn SIGINT, SIGTERM and the end of the lifeline into a stop request; a second signal ends the process.

    Main thread only.

    Args:
        lifeline: Whether standard input is a lifeline.
    """
    stop = Stop()

    def on_signal(signum: int, _frame: FrameType | None) -> None:
        signal.signal(signum, signal.SIG_DFL)
        stop.request(StopReason.SIGNAL)

    before = {signum: signal.signal(signum, on_signal) for signum in _SIGNALS}
    if lifeline:
        threading.Thread(target=_watch_lifeline, args=(stop,), name="lifeline", daemon=True).start()
    try:
        yield stop
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)


def _watch_lifeline(stop: Stop) -> None:
    try:
        while os.read(_STANDARD_INPUT, 4096):
            pass
    except OSError:
        pass  # a closed standard input counts as the end of the lifeline
    stop.request(StopReason.LIFELINE)
    time.sleep(LIFELINE_GRACE_S)
    os.kill(os.getpid(), signal.SIGKILL)
