"""Keeps processors from halting, for loops on a virtual machine.

A halted virtual processor is given away by its host, and comes back milliseconds after the timer that should
wake it. A process that does nothing at the lowest priority, SCHED_IDLE, keeps its processor: it gives way to
any other process at once, and costs power.
"""

import os
import sys
from typing import Final

from passafe_services.loop.process_exit import ProcessSpec
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.stop import StopReason, stop_requests

_NAME: Final = "awake"

_GRACE_S: Final = 10.0
"""On a busy machine the lowest priority has to wait even for its own end."""


def awake_specs() -> tuple[ProcessSpec, ...]:
    """One process for each processor that this one may use; none where SCHED_IDLE is not known."""
    if sys.platform != "linux":
        return ()
    return tuple(
        ProcessSpec(name=f"{_NAME}-{cpu}", argv=(sys.executable, "-P", "-m", __name__, str(cpu)), grace_s=_GRACE_S)
        for cpu in sorted(os.sched_getaffinity(0))
    )


def keep_awake(cpu: int) -> StopReason:
    """Keep one processor from halting until a signal or the end of the lifeline; returns which it was."""
    os.sched_setaffinity(0, {cpu})
    with stop_requests(lifeline=True) as stop:
        announce_ready(f"{_NAME}-{cpu}")
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
        while (reason := stop.reason) is None:
            pass  # to wait would be to halt
    return reason


if __name__ == "__main__":
    keep_awake(int(sys.argv[1]))
