"""Shift the wall clock of the processes of a fault campaign: each reads its own offset from a file, at every call.

Python imports this by itself from ``PYTHONPATH``, before any program.
"""

import os
import struct
import sys
import time
from collections.abc import Callable
from mmap import ACCESS_READ, mmap
from pathlib import Path

FOLDER = os.environ.get("PASSAFE_SHIFTED_CLOCKS", "")
COMMAND = "passafe_services.cli.run"


def offset_file(process: str) -> Path:
    """Return the file that holds the offset of a process, 8 bytes, ns."""
    return Path(FOLDER) / f"{process}.offset"


def shift_clock(process: str) -> None:
    """Add what the file says to the wall clock, whenever that is read."""
    with offset_file(process).open("rb") as file:
        offset = mmap(file.fileno(), 8, access=ACCESS_READ)
    unshifted_ns: Callable[[], int] = time.time_ns

    def time_ns() -> int:
        return unshifted_ns() + int(struct.unpack_from("<q", offset)[0])

    time.time_ns = time_ns
    time.time = lambda: time_ns() * 1e-9


if FOLDER and COMMAND in sys.orig_argv:
    shift_clock(sys.orig_argv[sys.orig_argv.index(COMMAND) + 1])
