"""What makes a process punctual: priority, precise sleep, a garbage collector that keeps out of the way."""

import ctypes
import gc
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

LOOP_PRIORITY: Final = 50
"""SCHED_FIFO priority of router and control loops."""

RECORDER_PRIORITY: Final = 20
"""SCHED_FIFO priority of a recorder: never in the way of a loop, never behind the rest of the machine."""

_PR_SET_TIMERSLACK: Final = 29


def request_realtime(priority: int = LOOP_PRIORITY) -> str | None:
    """Ask for SCHED_FIFO for this thread and those started later: call it before the bus is opened.

    Returns:
        ``None`` if granted, else why not; the process can go on without it.
    """
    _sleep_precisely()
    if not hasattr(os, "sched_setscheduler"):
        return f"no SCHED_FIFO on {sys.platform}"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        return f"no real-time priority ({error.strerror}): steps may be late under load"
    return None


@contextmanager
def quiet_collector() -> Iterator[Callable[[], None]]:
    """Keep Python's cyclic garbage collector from running at moments of its own choice.

    Everything alive now is set aside for good. The function that is handed out collects what was made since;
    called once a second it takes microseconds and bounds the garbage.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield _collect_young
    finally:
        gc.enable()
        gc.unfreeze()


def _collect_young() -> None:
    gc.collect(1)


def _sleep_precisely() -> None:
    """Let timers fire within 1 ns instead of 50 µs; real-time threads have that anyway."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
