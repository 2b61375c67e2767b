"""When a process is to stop: a signal, or the end of its lifeline.

A lifeline is standard input held open by whoever started the process. It ends when the holder does, however
that happens, so a supervised process never outlives its supervisor.
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
"""A process that has not ended so long after its lifeline did is killed."""

_STANDARD_INPUT: Final = 0
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


class StopReason(Enum):
    """Why a process stopped."""

    SIGNAL = "signal"
    LIFELINE = "end of the lifeline"
    DURATION = "end of its duration"
    FINISHED = "its own decision"


class Stop:
    """A request to stop; made by ``stop_requests``.

    It wakes a waiter through a pipe: a lock could be held by the very code that a signal handler interrupts.
    The pipe is never closed, since the lifeline's thread may write to it as long as the process lives.

    Attributes:
        reason: Why to stop; ``None`` as long as nobody asked.
    """

    def __init__(self) -> None:
        self.reason: StopReason | None = None
        self._read_end, self._write_end = os.pipe()

    def request(self, reason: StopReason) -> None:
        """Ask to stop; the first reason stays."""
        if self.reason is None:
            self.reason = reason
            os.write(self._write_end, b"\0")

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until somebody asks to stop, or for ``timeout_s``; tells whether somebody did."""
        select.select([self._read_end], [], [], timeout_s)
        return self.reason is not None


@contextmanager
def stop_requests(*, lifeline: bool) -> Iterator[Stop]:
    """Turn SIGINT, SIGTERM and the end of the lifeline into a request; a second signal ends the process.

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
        pass  # closed: as good as at its end
    stop.request(StopReason.LIFELINE)
    time.sleep(LIFELINE_GRACE_S)
    os.kill(os.getpid(), signal.SIGKILL)
