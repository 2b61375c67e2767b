"""A demo as a user starts it, for tests: its lines, its processes, its end."""

import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, Queue
from threading import Thread

import psutil

START_S = 90.0
"""A loaded machine takes long to import CasADi six times."""


class RunningDemo:
    """``passafe demo`` in a process of its own.

    Attributes:
        process: The supervisor.
        router: Where the router listens, host:port.
        router_port: Its port.
        lines: What it has printed so far.
    """

    def __init__(self, out: Path, arguments: tuple[str, ...]) -> None:
        self.router_port = free_port()
        self.router = f"127.0.0.1:{self.router_port}"
        ports = ("--router-port", str(self.router_port), "--port", str(free_port()))
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--out", str(out), *ports, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self.lines: list[str] = []
        self._queue: Queue[str] = Queue()
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def wait_for(self, pattern: str, timeout_s: float = START_S) -> str:
        """Return the first line, printed already or within ``timeout_s``, that matches."""
        end = time.monotonic() + timeout_s
        seen = 0
        while True:
            for line in self.lines[seen:]:
                if re.search(pattern, line):
                    return line
            seen = len(self.lines)
            try:
                self.lines.append(self._queue.get(timeout=max(0.0, end - time.monotonic())))
            except Empty:
                raise AssertionError(
                    f"no line like {pattern!r} within {timeout_s} s:\n" + "".join(self.lines)
                ) from None

    def children(self) -> dict[str, int]:
        """Return the process ids of the supervised processes by name."""
        found = {}
        for child in psutil.Process(self.process.pid).children():
            words = child.cmdline()
            found[words[words.index("passafe_services.cli.run") + 1]] = child.pid
        return found

    def end(self, timeout_s: float = 60.0) -> int:
        """Wait for the supervisor's end; return its exit code."""
        code = self.process.wait(timeout_s)
        self._reader.join(timeout_s)
        while not self._queue.empty():
            self.lines.append(self._queue.get())
        return code

    def dispose(self) -> None:
        """Kill what is left and close the pipe."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait(10.0)
        self._reader.join(30.0)
        assert self.process.stdout is not None
        self.process.stdout.close()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._queue.put(line)


@contextmanager
def running_demo(out: Path, *arguments: str) -> Iterator[RunningDemo]:
    """Start a demo; whatever happens, leave nothing of it behind."""
    demo = RunningDemo(out, arguments)
    try:
        yield demo
    finally:
        demo.dispose()


def alive(pid: int) -> bool:
    """Check that a process exists and is not a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def all_gone(pids: list[int], timeout_s: float) -> bool:
    """Wait until none of the processes is alive; tell whether that was in time."""
    end = time.monotonic() + timeout_s
    while any(alive(pid) for pid in pids):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)  # other processes' ends are no event that this one could wait for
    return True


def only_log(folder: Path) -> Path:
    """Return the log in a folder."""
    [log] = [path for path in folder.glob("*.mcap") if not path.name.endswith(".torn.mcap")]
    return log


def free_port() -> int:
    """Return a free port of the loopback interface."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])
