"""What makes a process punctual: priority, precise sleep, a garbage collector that keeps out of the way."""

import ctypes
import gc
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

LOOP_PRIORITY: Final = 50
"""SCHED_FIFO priority of router and control loops, and of the bus' threads.

Threads of the bus wait for one another in ways that keep a processor busy: with more than the priority of a loop on the
same processor they would keep from running what they wait for.
"""

ASIDE_PRIORITY: Final = 1
"""SCHED_FIFO priority of a process that gets ready."""

RECORDER_PRIORITY: Final = 20
"""SCHED_FIFO priority of a recorder: never in the way of a loop, never behind the rest of the machine."""

LOOPS: Final = ("filter", "plant", "operator")
"""Processes with a loop, the one that has most to do first."""

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


def step_aside() -> None:
    """Go on after every loop, though before all that has no deadline: to get ready takes tens of milliseconds.

    Nothing happens without real-time priority; ``request_realtime`` takes it back.
    """
    if hasattr(os, "sched_setscheduler") and os.sched_getscheduler(0) == os.SCHED_FIFO:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(ASIDE_PRIORITY))


def own_processor(name: str) -> None:
    """Keep this thread on one processor: each loop's on another, as far as there are enough.

    Linux leaves loops of one priority where they ran last, several on one processor, and takes every processor that
    spends 95 % of a second in real time away from them for the rest of it (``sched_rt_runtime_us``).

    Args:
        name: Name of the process; nothing happens if it has no loop.
    """
    if name in LOOPS and hasattr(os, "sched_setaffinity"):
        allowed = sorted(os.sched_getaffinity(0), reverse=True)  # the first ones have interrupts to serve
        os.sched_setaffinity(0, {allowed[min(LOOPS.index(name), len(allowed) - 1)]})


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def give_way() -> None:
    """Let the bus' threads run, which have the priority and the processor of a loop that does not come to rest."""
    if hasattr(os, "sched_yield"):
        os.sched_yield()


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
