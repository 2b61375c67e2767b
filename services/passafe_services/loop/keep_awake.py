"""Keeps processors from halting, for loops on a virtual machine.

A host may schedule a halted virtual processor away and return it milliseconds after the timer that should wake it. A
busy loop at the lowest priority, SCHED_IDLE, keeps the processor running: every other process preempts it at once. It
costs power.
"""

import os
import sys
from typing import Final

from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.stop import StopReason, stop_requests

_NAME: Final = "awake"

_GRACE_S: Final = 10.0
"""On a busy machine a process of the lowest priority takes long even to end."""


def awake_specs() -> tuple[ProcessSpec, ...]:
    """Return one process for each processor that this one may use; none without SCHED_IDLE."""
    if sys.platform != "linux":
        return ()
    return tuple(
        ProcessSpec(name=f"{_NAME}-{cpu}", argv=(sys.executable, "-P", "-m", __name__, str(cpu)), grace_s=_GRACE_S)
        for cpu in sorted(os.sched_getaffinity(0))
    )


def keep_awake(cpu: int) -> StopReason:
    """Keep one processor from halting until a signal or the end of the lifeline; return which it was."""
    os.sched_setaffinity(0, {cpu})
    with stop_requests(lifeline=True) as stop:
        announce_ready(f"{_NAME}-{cpu}")
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
        while (reason := stop.reason) is None:
            pass  # waiting would halt the processor
    return reason


if __name__ == "__main__":
    keep_awake(int(sys.argv[1]))
