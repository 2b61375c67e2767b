"""Runs ``passafe demo`` for a benchmark and reads its messages."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
from passafe_protocol.codec import decode
from passafe_protocol.messages import Header, Message, PlantPhase, PlantState
from passafe_protocol.topics import COMMAND, STATE, TICK, Topic
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.realtime import RECORDER_PRIORITY, request_realtime
from passafe_services.loop.router_endpoint import RouterEndpoint

START_S = 180.0
PATIENCE_S = 60.0
"""Longest wait for a message: a loaded machine starts processes slowly."""

Wanted = Callable[[Header, Message], bool]


class NoRobotError(Exception):
    """A demo that did not come up."""


class LiveDemo:
    """A running demo.

    Attributes:
        process: The supervisor.
        bus: Session with its router.
        port: Port of its router.
    """

    def __init__(self, process: "subprocess.Popen[str]", bus: Bus, port: int) -> None:
        """Subscribe to what the robot, the operator and the filter send."""
        self.process = process
        self.bus = bus
        self.port = port
        self._readers = {topic: bus.reader(topic) for topic in (STATE, COMMAND, TICK)}

    def pid(self, name: str) -> int:
        """Return the process id of a supervised process.

        Raises:
            ProcessLookupError: There is none of that name.
        """
        for child in psutil.Process(self.process.pid).children():
            if name in child.cmdline():
                return int(child.pid)
        raise ProcessLookupError(name)

    def receives(self, topic: Topic, wanted: Wanted, patience_s: float = PATIENCE_S) -> bool:
        """Wait for a message; return whether one came in time."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end and self.process.poll() is None:
            if any(wanted(*decode(topic, data)) for data in self._readers[topic].drain()):
                return True
            time.sleep(0.005)
        return False

    def newest_epoch(self, topic: Topic) -> int:
        """Return the session of the process that publishes a topic now; 0 if none does."""
        epochs: list[int] = []

        def keep(header: Header, _: Message) -> bool:
            epochs.append(header.epoch)
            return True

        self.receives(topic, keep)
        return max(epochs, default=0)


def is_running(body: Message) -> bool:
    """Return whether a plant state is one with an input of the filter in force."""
    return isinstance(body, PlantState) and body.phase is PlantPhase.RUNNING


def wait_for_router(process: "subprocess.Popen[str]", port: int, lines: Path) -> None:
    """Wait until a demo's router listens.

    Raises:
        NoRobotError: The demo ended before that.
    """
    while process.poll() is None:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1.0):
            return
        time.sleep(0.05)
    raise NoRobotError(lines.read_text(encoding="utf-8").strip())


@contextmanager
def live_demo(scenario: Path, out: Path, rate_hz: float) -> Iterator[LiveDemo]:
    """Run a demo that restarts what dies; nothing of it is left afterwards.

    Raises:
        NoRobotError: It did not come up.
        BusError: Its router did not.
    """
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = int(server.getsockname()[1])
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--restart", "--headless"]
    arguments = ["--scenario", str(scenario), "--out", str(out), "--router-port", str(port), "--rate", str(rate_hz)]
    with (out / "demo.txt").open("w", encoding="utf-8") as lines:
        process = subprocess.Popen([*command, *arguments], stdout=lines, stderr=lines, text=True)  # noqa: S603 - ours
        request_realtime(RECORDER_PRIORITY)  # after the demo was started, which would inherit it
        try:
            wait_for_router(process, port, out / "demo.txt")
            with open_bus(RouterEndpoint.of_demo(port, "recorder"), timeout_s=START_S) as bus:
                demo = LiveDemo(process, bus, port)
                if not demo.receives(STATE, lambda _, body: is_running(body), START_S):
                    raise NoRobotError(f"no robot moved; see {out / 'demo.txt'}")
                yield demo
                process.send_signal(signal.SIGINT)
            psutil.wait_procs(psutil.Process(process.pid).children(), PATIENCE_S)
        finally:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            process.kill()  # the log is finished by now; if it is not, the children end with their supervisor
            process.wait()
