"""Real processes for the tests of the live runtime, none of which outlives its test."""

import json
import queue
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from passafe_services.loop.readiness import ready_line
from supervised_toys import Terminal

TOY = Path(__file__).with_name("toy_process.py")
PATIENCE_S = 20.0


class Toy:
    """A started toy process; its lines are read as they come."""

    def __init__(self, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(TOY), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.pid = self.process.pid
        self._lines: queue.Queue[str] = queue.Queue()
        self._errors: list[str] = []
        self._threads = [
            threading.Thread(target=self._read, daemon=True),
            threading.Thread(target=self._read_errors, daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def line(self) -> str:
        """Next line of standard output."""
        return self._lines.get(timeout=PATIENCE_S)

    def wait_ready(self, name: str) -> None:
        """Until it says that it is ready, which must be the next it says."""
        line = self.line()
        assert line == ready_line(name), line

    def output(self) -> dict[str, Any]:
        """Next line of standard output as JSON."""
        return json.loads(self.line())

    def cut_lifeline(self) -> None:
        """End its standard input."""
        self.process.stdin.close()

    def end(self) -> tuple[int, str]:
        """Exit code and standard error, once it has ended."""
        code = self.process.wait(PATIENCE_S)
        for thread in self._threads:
            thread.join(PATIENCE_S)
        return code, "".join(self._errors)

    def dispose(self) -> None:
        """Kill it if it still lives."""
        if self.process.poll() is None:
            self.process.kill()
        self.end()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            pipe.close()

    def _read(self) -> None:
        for line in self.process.stdout:
            self._lines.put(line.rstrip("\n"))

    def _read_errors(self) -> None:
        self._errors.extend(self.process.stderr)


@pytest.fixture
def start() -> Iterator[Callable[..., Toy]]:
    """Start toy processes and end them after the test."""
    toys: list[Toy] = []

    def start_toy(*arguments: object) -> Toy:
        toys.append(Toy(*map(str, arguments)))
        return toys[-1]

    yield start_toy
    for toy in reversed(toys):
        toy.dispose()


@pytest.fixture
def port() -> int:
    """Return a free port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def router(start: Callable[..., Toy], port: int) -> Toy:
    """Start a router on ``port``."""
    toy = start("router", "--port", port)
    toy.wait_ready("router")
    return toy


@pytest.fixture
def terminal() -> Terminal:
    """Return what receives the output of a supervisor."""
    return Terminal()
