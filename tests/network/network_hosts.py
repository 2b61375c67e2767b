"""Hosts on one machine: network namespaces joined by a bridge, with clocks of their own."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from passafe_services.loop.readiness import ready_line

PREFIX: Final = "passafe-t"
SUBNET: Final = "10.213.77"
SKEWED: Final = Path(__file__).with_name("skewed_process.py")


@dataclass(frozen=True, kw_only=True)
class Host:
    """A network namespace.

    Attributes:
        name: Its name.
        address: Its address on the common network.
        monotonic_offset_s: How far its monotonic clock is ahead, s.
        wall_offset_s: How far its wall clock is ahead, s.
    """

    name: str
    address: str
    monotonic_offset_s: int = 0
    wall_offset_s: int = 0

    def start_passafe(self, process: str, *options: str, output: Path) -> subprocess.Popen[bytes]:
        """Start one process of passafe by this host's clocks."""
        return self.start(sys.executable, "-P", str(SKEWED), str(self.wall_offset_s), process, *options, output=output)

    def start(self, *command: str, output: Path) -> subprocess.Popen[bytes]:
        """Start a program on this host; what it prints goes to a file."""
        words = ["ip", "netns", "exec", self.name]
        if self.monotonic_offset_s:
            words += ["unshare", "--time", "--fork", "--kill-child"]
            words += ["--monotonic", str(self.monotonic_offset_s), "--boottime", str(self.monotonic_offset_s)]
        with output.open("wb") as file:
            return subprocess.Popen(
                [*words, *command],
                stdout=file,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )


def why_not() -> str:
    """Return why this machine cannot have such hosts; empty if it can."""
    for program in ("ip", "unshare", "pkill"):
        if shutil.which(program) is None:
            return f"{program} is not installed (Debian: iproute2, util-linux, procps)"
    if os.geteuid() != 0:
        return "network namespaces need root"
    probe = f"{PREFIX}probe"
    made = _ip("netns", "add", probe, check=False)
    _ip("netns", "delete", probe, check=False)
    if made.returncode != 0:
        return f"no network namespaces: {made.stderr.strip()}"
    unshare = ("unshare", "--time", "--fork", "true")
    clocks = subprocess.run(unshare, capture_output=True, text=True, check=False)
    return "" if clocks.returncode == 0 else f"no time namespaces: {clocks.stderr.strip()}"


@contextmanager
def network(*hosts: Host) -> Iterator[None]:
    """Make the hosts and a bridge between them; remove all of it at the end."""
    bridge = f"{PREFIX}br"
    try:
        _ip("netns", "add", bridge)
        _ip("-n", bridge, "link", "add", "br0", "type", "bridge")
        _ip("-n", bridge, "link", "set", "br0", "up")
        for number, host in enumerate(hosts):
            port = f"p{number}"
            _ip("netns", "add", host.name)
            _ip("-n", host.name, "link", "set", "lo", "up")
            _ip("-n", host.name, "link", "add", "eth0", "type", "veth", "peer", "name", port, "netns", bridge)
            _ip("-n", host.name, "address", "add", f"{host.address}/24", "dev", "eth0")
            _ip("-n", host.name, "link", "set", "eth0", "up")
            _ip("-n", bridge, "link", "set", port, "master", "br0", "up")
        yield
    finally:
        for name in (*(host.name for host in hosts), bridge):
            _ip("netns", "delete", name, check=False)


def is_ready(process: str, output: Path) -> bool:
    """Return whether a process has printed its ready line."""
    return ready_line(process) in output.read_text(encoding="utf-8", errors="replace").splitlines()


def _ip(*words: str, check: bool = True) -> subprocess.CompletedProcess[str]:
    command = ("ip", *words)
    return subprocess.run(command, capture_output=True, text=True, check=check)
