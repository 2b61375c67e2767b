"""Watch over calls that a loop waits for and that may not return: the loop itself could no longer report it."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from passafe_services.loop.realtime import outrank_loops, suspend_realtime

LOOK_S: Final = 0.1
"""Time between two looks."""

PATIENCE_LOOKS: Final = 20
"""Looks in a row at one call after which it hangs: looks and not time, since a suspended process hangs in nothing."""

SLOW_LOOKS: Final = 2
"""Looks in a row after which the loop has no real-time priority until the call returns: in a busy loop it would starve
the threads of the bus and other loops on its processor."""

SLOW_S: Final = LOOK_S * SLOW_LOOKS
"""The same in s, of a process that runs."""

HANG_S: Final = LOOK_S * PATIENCE_LOOKS
"""The same in s, of a process that runs."""

Call = tuple[int, str]
"""Number of a call, and its name in words."""


@contextmanager
def hang_watch(current: Callable[[], Call | None] | None, on_hang: Callable[[str], object]) -> Iterator[list[str]]:
    """Look at the call that the loop in the main thread waits for, in another one, while the block runs.

    Args:
        current: Returns the call; ``None`` between calls. No watch if not given.
        on_hang: Called once, in that thread, with the name of a call that does not return.

    Yields:
        Names of calls that are or were slow, to be taken out by the loop when it is back.
    """
    slow: list[str] = []
    if current is None:
        yield slow
        return
    done = threading.Event()
    threading.Thread(target=_watch, args=(current, on_hang, slow, done), name="hang-watch", daemon=True).start()
    try:
        yield slow
    finally:
        done.set()


def _watch(
    current: Callable[[], Call | None], on_hang: Callable[[str], object], slow: list[str], done: threading.Event
) -> None:
    outrank_loops()
    restore: Callable[[], object] | None = None
    before, looks = None, 0
    while not done.wait(LOOK_S):
        call = current()
        looks = looks + 1 if call is not None and call == before else 0
        before = call
        if call is not None and looks == SLOW_LOOKS:
            slow.append(call[1])
            restore = suspend_realtime(threading.main_thread())
        elif looks == 0 and restore is not None:
            restore()
            restore = None
        if call is not None and looks >= PATIENCE_LOOKS:
            on_hang(call[1])
            return
