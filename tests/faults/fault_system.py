"""A running demo whose processes can be hurt: with a page, and a clock of its own for each process."""

import os
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic_ns

import psutil

sys.path.append(str(Path(__file__).parents[1] / "system"))

from running_demo import RunningDemo, running_demo

CLOCKS = Path(__file__).with_name("shifted_clock")
PROCESSES = ("router", "recorder", "dashboard", "operator", "filter", "plant")
CLOCKED = ("recorder", "dashboard", "operator", "filter", "plant")


class FaultSystem:
    """A demo and what hurts it.

    Attributes:
        demo: The running demo.
        folder: Folder of its log.
        clocks: Folder of the offsets of its clocks.
        pids: Process ids by name, as of the start.
    """

    def __init__(self, demo: RunningDemo, folder: Path, clocks: Path) -> None:
        self.demo = demo
        self.folder = folder
        self.clocks = clocks
        self.pids = demo.children()

    def process(self, name: str) -> psutil.Process:
        """Return a process as it is now: it may have been restarted; ``demo`` is the supervisor itself."""
        return psutil.Process(self.demo.process.pid if name == "demo" else self.demo.children()[name])

    def set_clock(self, name: str, offset_s: float) -> None:
        """Shift the wall clock of a process."""
        with (self.clocks / f"{name}.offset").open("r+b") as file:
            file.write(struct.pack("<q", round(1e9 * offset_s)))

    @property
    def log(self) -> Path:
        """The log, torn or whole."""
        found = sorted(self.folder.glob("*.mcap"), key=lambda path: path.name.endswith(".torn.mcap"))
        return found[0]

    @property
    def page(self) -> int:
        """Port of the page."""
        return int(self.demo.wait_for("dashboard http").rstrip("/\n").rpartition(":")[2])


@contextmanager
def fault_system(folder: Path, clocks: Path, *arguments: str) -> Iterator[FaultSystem]:
    """Run a demo that logs into ``folder``; yield when it is driving.

    Args:
        folder: Folder of the log.
        clocks: Folder for the offsets of the clocks.
        arguments: Further arguments of ``passafe demo``.
    """
    for name in PROCESSES:
        (clocks / f"{name}.offset").write_bytes(bytes(8))
    before = {key: os.environ.get(key) for key in ("PYTHONPATH", "PASSAFE_SHIFTED_CLOCKS")}
    os.environ |= {"PYTHONPATH": str(CLOCKS), "PASSAFE_SHIFTED_CLOCKS": str(clocks)}
    try:
        with running_demo(folder, "--rate", "250", *arguments) as demo:
            demo.wait_for("running")
            yield FaultSystem(demo, folder, clocks)
    finally:
        for key, value in before.items():
            if value is None:
                del os.environ[key]
            else:
                os.environ[key] = value


def now_ns() -> int:
    """Return the monotonic clock, which all processes of this machine share."""
    return monotonic_ns()
