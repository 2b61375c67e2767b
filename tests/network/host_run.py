"""A run of the system over several hosts, without a supervisor: each process starts where it belongs."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from network_hosts import PREFIX, SUBNET, Host, is_ready, network
from passafe_services.cli.app import app
from typer.testing import CliRunner

START_S: Final = 60.0
END_S: Final = 20.0
ROUTER_PORT: Final = 7447
RELAY_PORT: Final = 7448
RELAY: Final = Path(__file__).with_name("tcp_relay.py")

DESK: Final = Host(name=f"{PREFIX}desk", address=f"{SUBNET}.2", wall_offset_s=3_600)
MIDDLE: Final = Host(name=f"{PREFIX}mid", address=f"{SUBNET}.1")
ROBOT: Final = Host(name=f"{PREFIX}bot", address=f"{SUBNET}.3", monotonic_offset_s=100_000, wall_offset_s=7_200)


@dataclass(kw_only=True)
class HostRun:
    """Processes on three hosts: the operator at a desk, the plant at the robot, the rest in the middle.

    Attributes:
        folder: For keys, output and log.
        scenario: The scenario's file.
        relay: Options of the relay between the robot and the router.
    """

    folder: Path
    scenario: Path
    relay: Sequence[str]
    running: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    @property
    def log(self) -> Path:
        """The recorder's log."""
        return self.folder / "run.mcap"

    def output(self, name: str) -> Path:
        """Return the file with what a program prints."""
        return self.folder / f"{name}.txt"

    def start(self) -> None:
        """Start every program, the plant last; each once the one before is ready."""
        self._start_process("router", MIDDLE, f"0.0.0.0:{ROUTER_PORT}")
        listen, to = (f"{MIDDLE.address}:{port}" for port in (RELAY_PORT, ROUTER_PORT))
        words = (sys.executable, str(RELAY), "--listen", listen, "--to", to, *self.relay)
        self.running["relay"] = MIDDLE.start(*words, output=self.output("relay"))
        direct = f"{MIDDLE.address}:{ROUTER_PORT}"
        self._start_process("recorder", MIDDLE, direct, "--out", str(self.log))
        self._start_process("filter", MIDDLE, direct)
        self._start_process("operator", DESK, direct)
        self._start_process("plant", ROBOT, f"{MIDDLE.address}:{RELAY_PORT}")

    def stop(self) -> None:
        """End the processes, the plant first, and check that each ends in order."""
        for name in ("plant", "operator", "filter", "recorder", "router"):
            group = self.running.pop(name)
            command = ("pkill", "-TERM", "--session", str(group.pid), "python")
            subprocess.run(command, check=False)
            assert group.wait(END_S) in {0, -signal.SIGTERM}, self.output(name).read_text(encoding="utf-8")

    def kill(self) -> None:
        """Kill what is left."""
        for group in self.running.values():
            group.kill()
            group.wait(END_S)

    def _start_process(self, name: str, host: Host, router: str, *options: str) -> None:
        keys = self.folder / "keys" / (name if name == "router" else f"{name}.robot")
        common = ("--scenario", str(self.scenario), "--router", router, "--keys", str(keys))
        self.running[name] = host.start_passafe(name, *common, *options, output=self.output(name))
        end = time.monotonic() + START_S
        while not is_ready(name, self.output(name)):
            assert time.monotonic() < end, self.output(name).read_text(encoding="utf-8")
            assert self.running[name].poll() is None, self.output(name).read_text(encoding="utf-8")
            time.sleep(0.05)  # a file that another process writes is no event to wait for


@contextmanager
def host_run(folder: Path, scenario: Path, relay: Sequence[str] = ()) -> Iterator[HostRun]:
    """Make hosts and keys, start the processes, and leave nothing behind."""
    made = CliRunner().invoke(app, ["keys", "make", str(folder / "keys"), "--host", MIDDLE.address])
    assert made.exit_code == 0, made.output
    run = HostRun(folder=folder, scenario=scenario, relay=relay)
    with network(DESK, MIDDLE, ROBOT):
        try:
            run.start()
            yield run
        finally:
            run.kill()
