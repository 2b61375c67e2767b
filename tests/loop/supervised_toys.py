"""Toys under a supervisor, and what it prints."""

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from passafe_services.loop.process_spec import ProcessSpec, RestartPolicy

TOY = str(Path(__file__).with_name("toy_process.py"))
PATIENCE_S = 20.0


def toy(
    name: str, kind: str = "plain", *arguments: object, grace_s: float = 10.0, restarts: RestartPolicy | None = None
) -> ProcessSpec:
    argv = (sys.executable, TOY, kind, "--name", name, *map(str, arguments))
    return ProcessSpec(name=name, argv=argv, grace_s=grace_s, restarts=restarts)


class Terminal:
    """Output of a supervisor with times, and the pids that the toys print."""

    def __init__(self) -> None:
        self.lines: list[tuple[float, str]] = []
        self.pids: dict[str, dict[str, int]] = {}
        self.said_pid: list[tuple[str, int]] = []
        self.on_pid: Callable[[str, int], None] = lambda _name, _pid: None

    def __call__(self, line: str) -> None:
        """Take a line."""
        self.lines.append((time.monotonic(), line))
        name, bar, text = line.partition(" | ")
        if bar and text.startswith("{"):
            output = json.loads(text)
            if "pid" in output:
                self.pids[name.strip()] = output
                self.said_pid.append((name.strip(), output["pid"]))
                self.on_pid(name.strip(), output["pid"])

    def when(self, text: str) -> float:
        """Return the time of the first line with ``text``."""
        return next(at for at, line in self.lines if text in line)

    @property
    def texts(self) -> list[str]:
        """The lines without their times."""
        return [line for _, line in self.lines]

    @property
    def all_pids(self) -> list[int]:
        """Of all toys and what they started."""
        return [pid for output in self.pids.values() for pid in output.values()]


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


def gone(pids: list[int]) -> bool:
    """Wait until all of them have ended; return false after a timeout."""
    end = time.monotonic() + PATIENCE_S
    while any(alive(pid) for pid in pids):
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True
