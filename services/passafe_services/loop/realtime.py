"""Real-time settings of a process: priority, processor, timer slack and garbage collection."""

import ctypes
import gc
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Final

LOOP_PRIORITY: Final = 50
"""SCHED_FIFO priority of router and control loops, and of the bus' threads.

Threads of the bus spin while they wait for one another: with a higher priority than a loop on the same processor, they
would starve the thread that they wait for.
"""

SETUP_PRIORITY: Final = 1
"""SCHED_FIFO priority of a process during setup."""

RECORDER_PRIORITY: Final = 20
"""SCHED_FIFO priority of a recorder: below the loops, above all other processes."""

LOOPS: Final = ("filter", "plant", "operator")
"""Processes with a control loop, the most demanding first."""

_PR_SET_TIMERSLACK: Final = 29


def request_realtime(priority: int = LOOP_PRIORITY) -> str | None:
    """Request SCHED_FIFO for this thread and those started later: call it before the bus is opened.

    Returns:
        ``None`` if granted, else the reason for the refusal; the process can continue without it.
    """
    _sleep_precisely()
    if not hasattr(os, "sched_setscheduler"):
        return f"no SCHED_FIFO on {sys.platform}"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        return f"no real-time priority ({error.strerror}): steps may be late under load"
    return None


def lower_priority() -> None:
    """Continue with ``SETUP_PRIORITY`` for the setup, which takes tens of milliseconds: after loops, before the rest.

    Without real-time priority nothing happens; ``request_realtime`` restores the priority.
    """
    if hasattr(os, "sched_setscheduler") and os.sched_getscheduler(0) == os.SCHED_FIFO:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(SETUP_PRIORITY))


def outrank_loops() -> None:
    """Give this thread a priority above all loops, where it has one at all: what watches a loop must run beside it."""
    if hasattr(os, "sched_setscheduler") and os.sched_getscheduler(0) == os.SCHED_FIFO:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LOOP_PRIORITY + 1))


def suspend_realtime(thread: threading.Thread) -> Callable[[], object]:
    """Take the real-time priority of a thread; return what gives it back, which does nothing where there was none."""
    if not hasattr(os, "sched_setscheduler") or thread.native_id is None:
        return lambda: None
    policy, parameter = os.sched_getscheduler(thread.native_id), os.sched_getparam(thread.native_id)
    if policy != os.SCHED_FIFO:
        return lambda: None
    os.sched_setscheduler(thread.native_id, os.SCHED_OTHER, os.sched_param(0))
    return partial(os.sched_setscheduler, thread.native_id, policy, parameter)


def pin_to_processor(name: str) -> None:
    """Pin this thread to one processor, a different one for each loop if there are enough.

    Linux leaves loops of the same priority where they ran last, possibly several on one processor, and throttles
    real-time threads on a processor that spends 95 % of a second in them (``sched_rt_runtime_us``).

    Args:
        name: Name of the process; nothing happens if it has no control loop.
    """
    if name in LOOPS and hasattr(os, "sched_setaffinity"):
        allowed = sorted(os.sched_getaffinity(0), reverse=True)  # the first ones serve interrupts
        os.sched_setaffinity(0, {allowed[min(LOOPS.index(name), len(allowed) - 1)]})


def available_processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def yield_processor() -> None:
    """Let the threads of the bus run, which share priority and processor with a loop that never sleeps."""
    if hasattr(os, "sched_yield"):
        os.sched_yield()


@contextmanager
def paused_garbage_collection() -> Iterator[Callable[[], object]]:
    """Disable Python's automatic cyclic garbage collection within the block.

    Objects that exist now are frozen. The yielded function collects objects created since; called once a second, it
    takes microseconds and bounds the garbage.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield partial(gc.collect, 1)
    finally:
        gc.enable()
        gc.unfreeze()


def _sleep_precisely() -> None:
    """Reduce the timer slack from 50 µs to 1 ns; real-time threads have none anyway."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
