"""Runs a demo for long and looks for growth: ``make soak``; 30 minutes by default.

Once a second the memory, file handles and threads of every process are read from ``/proc``. They have settled after the
first sixth of the run; from then on each must stay level.
"""

import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, NamedTuple

import typer
from passafe_protocol.topics import PROCESSES

GROWTH_MB = 8.0
"""Largest growth of a process from the first to the last third after settling, MB; a log's index grows."""

SETTLED = 1 / 6
PAGE_MB = 4096 / 1e6


class Usage(NamedTuple):
    """Usage of a process at an instant."""

    memory_mb: float
    handles: int
    threads: int


def usage_of(pid: int) -> Usage | None:
    """Return the usage of a process; ``None`` if it has ended."""
    place = Path("/proc") / str(pid)
    try:
        pages = int((place / "statm").read_text().split()[1])
        return Usage(pages * PAGE_MB, len(list((place / "fd").iterdir())), len(list((place / "task").iterdir())))
    except OSError:
        return None


def children_of(pid: int) -> dict[int, str]:
    """Return name by process id of the processes that a demo started."""
    found = {}
    listed = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    for child in map(int, listed):
        try:
            words = Path(f"/proc/{child}/cmdline").read_text().split("\0")
        except OSError:
            continue
        found[child] = next((word for word in words if word in PROCESSES), "other")
    return found


def growth(values: list[float]) -> float:
    """Return the median of the last third less that of the first third, after settling."""
    settled = values[round(SETTLED * len(values)) :]
    third = max(1, len(settled) // 3)
    first, last = sorted(settled[:third]), sorted(settled[-third:])
    return last[len(last) // 2] - first[len(first) // 2]


def main(
    minutes: Annotated[float, typer.Option(min=0.1, help="Length of the run.")] = 30.0,
    rate_hz: Annotated[float, typer.Option("--rate", help="Rate of the loops.")] = 500.0,
    growth_mb: Annotated[float, typer.Option("--growth", help="Largest growth of memory, MB.")] = GROWTH_MB,
    router_port: Annotated[int, typer.Option(help="Port of the router.")] = 17447,
) -> None:
    """Print the growth of each process; exit with 1 if one grows, or the run does not hold."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--headless", "--out", folder]
        options = ["--duration", str(60.0 * minutes), "--rate", str(rate_hz), "--router-port", str(router_port)]
        demo = subprocess.Popen([*command, *options])
        seen: dict[str, list[Usage]] = {}
        while demo.poll() is None:
            for pid, name in children_of(demo.pid).items():
                usage = usage_of(pid)
                if usage is not None:
                    seen.setdefault(name, []).append(usage)
            time.sleep(1.0)
    failed = demo.returncode != 0
    for name, usages in seen.items():
        memory, handles, threads = (growth([float(each[k]) for each in usages]) for k in range(3))
        grows = memory > growth_mb or handles > 0 or threads > 0
        failed |= grows
        last = f"{usages[-1].memory_mb:.1f} MB, {usages[-1].handles} handles, {usages[-1].threads} threads"
        sys.stdout.write(f"{name}: {last}; growth {memory:+.2f} MB, {handles:+.0f}, {threads:+.0f}")
        sys.stdout.write("  GROWS\n" if grows else "\n")
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    typer.run(main)
