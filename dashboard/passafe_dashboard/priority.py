"""Ask for a greater share of the processor for the process that carries a driver's commands."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

NICENESS: Final = -10
"""Niceness of the page's server: nine times the weight of an ordinary process such as a browser.

It needs a tenth of a processor, and is served below the control loops, which have real-time priority. A real-time
priority of its own would let a flood of requests eat into the time of the loops.
"""


def serve_before_others() -> None:
    """Run this thread, and those that it starts, before ordinary processes, where that is permitted."""
    with suppress(OSError, AttributeError):  # the usual share remains
        os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
        # With autogroup scheduling, niceness applies within a session's group, and the group has a niceness of its own.
        Path("/proc/self/autogroup").write_text(str(NICENESS), encoding="ascii")
