"""A seeded campaign of kills: a worker is killed at a random moment, and its parent has to report it at once.

``python tests/runs/worker_kills.py --kills 500``. Most kills hit workers that start, compute, or send results of up to
megabytes, more than a pipe holds; every tenth hits a worker of ``passafe experiment`` itself, which must end with one
line and exit code 2. A kill that is not reported in time ends the script with the stacks of all threads.
"""

import faulthandler
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer
from passafe_services.tools.runs.errors import WorkerLostError
from passafe_services.tools.runs.sweep import sweep
from passafe_services.tools.runs.worker_processes import WorkerProcesses
from sleep_job import SleepJob, Task

BOUND_S: Final = 60.0
"""By then the parent has ended, on the most loaded machine."""

EVERY_TENTH: Final = 10

AT_WORK: Final = 0.8
"""Share of the kills that wait for a first result."""

EXPERIMENT: Final = """
schema_version = 2
name = "kills"
title = "Kills"
scenario = "notomista-cai-2020"
seeds = { count = 5000 }
overrides = { duration_s = 0.1 }
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Kill:
    """One kill.

    Attributes:
        of: ``pool`` or ``command``.
        delay_s: To the kill from the start of the workers or, mostly, from the first result, s.
        results: Results received before.
        reported_s: From the kill to its report, s.
        ended_s: From the kill to the end of all workers, s.
    """

    of: str
    delay_s: float
    results: int
    reported_s: float
    ended_s: float


class EndlessPlan:
    """Wants another task for every result."""

    def __init__(self, rng: np.random.Generator, tasks: int) -> None:
        self._rng, self._tasks = rng, tasks
        self.results = 0

    def first(self) -> list[Task]:
        """Return some tasks."""
        return [self._task() for _ in range(self._tasks)]

    def after(self, _result: object) -> Sequence[Task]:
        """Return one more."""
        self.results += 1
        return [self._task()]

    def _task(self) -> Task:
        """Return a task of up to 20 ms with a result of up to 3 MB."""
        return Task(sleep_s=self._rng.uniform(0.0, 0.02), size=int(10 ** self._rng.uniform(0.0, 6.5)))


def kill_of_pool(seed: int) -> Kill:
    """Kill a worker of a pool and wait for the report."""
    rng = np.random.default_rng(seed)
    count, delay_s, at_work = int(rng.integers(1, 4)), float(rng.uniform(0.0, 0.3)), rng.random() < AT_WORK
    plan = EndlessPlan(rng, 3 * count)
    victim = int(rng.integers(count))
    killed_s: list[float] = []

    def kill(workers: "WorkerProcesses[Task, tuple[int, bytes]]") -> None:
        killed_s.append(time.monotonic())
        os.kill(workers.processes[victim].pid or 0, signal.SIGKILL)

    reported_s = float("inf")
    with closing(WorkerProcesses(SleepJob(), count)) as workers:
        timer = threading.Timer(delay_s, kill, [workers])
        if not at_work:
            timer.start()
        try:
            for _ in sweep(plan, workers, lambda _: 1):
                if at_work and plan.results == 1:
                    timer.start()
        except WorkerLostError:
            reported_s = time.monotonic() - killed_s[0]
    ended_s = time.monotonic() - killed_s[0]
    return Kill(of="pool", delay_s=delay_s, results=plan.results, reported_s=reported_s, ended_s=ended_s)


def kill_of_command(seed: int, folder: Path) -> Kill:
    """Kill a worker of ``passafe experiment`` and wait for its end."""
    rng = np.random.default_rng(seed)
    file, out, delay_s = folder / "kills.toml", folder / f"out-{seed}", float(rng.uniform(0.0, 1.0))
    at_work = rng.random() < AT_WORK
    file.write_text(EXPERIMENT, encoding="utf-8")
    arguments = ["experiment", str(file), "--out", str(out), "--workers", "2"]
    command = [sys.executable, "-P", "-m", "passafe_services.cli", *arguments]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as running:
        while len(workers := workers_of(running.pid)) < 2 or (at_work and not results_in(out)):
            assert running.poll() is None, running.stderr and running.stderr.read()
            time.sleep(0.01)
        time.sleep(delay_s)
        killed_s = time.monotonic()
        os.kill(workers[int(rng.integers(2))], signal.SIGKILL)
        assert running.stderr is not None
        last = next(line for line in running.stderr if "a worker process died" in line)
        reported_s = time.monotonic() - killed_s
        assert running.wait() == 2, last
        ended_s = time.monotonic() - killed_s
    return Kill(of="command", delay_s=delay_s, results=results_in(out), reported_s=reported_s, ended_s=ended_s)


def results_in(folder: Path) -> int:
    """Return how many results a command has written."""
    return (folder / "results.jsonl").read_text(encoding="utf-8").count("\n") - 1


def workers_of(pid: int) -> list[int]:
    """Return the worker processes of a process, without the tracker of resources that has none to do."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
        return [int(child) for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]
    except OSError:
        return []


def kills(count: int, first_seed: int) -> list[Kill]:
    """Make a number of kills, each within ``BOUND_S``."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first_seed, first_seed + count):
            faulthandler.dump_traceback_later(BOUND_S, exit=True)
            is_command = seed % EVERY_TENTH == 0
            found.append(kill_of_command(seed, Path(folder)) if is_command else kill_of_pool(seed))
            faulthandler.cancel_dump_traceback_later()
    return found


def main(
    count: Annotated[int, typer.Option("--kills", min=1, help="How many.")] = 500,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first; the others follow.")] = 0,
) -> None:
    """Kill workers at random moments and print how long their parents took to report it."""
    found = kills(count, first_seed)
    for of, number in Counter(kill.of for kill in found).items():
        some = [kill for kill in found if kill.of == of]
        reported, ended = ([getattr(kill, name) for kill in some] for name in ("reported_s", "ended_s"))
        facts = {
            "kills": number,
            "before_the_first_result": sum(not kill.results for kill in some),
            "reported_s_median": float(np.median(reported)),
            "reported_s_worst": max(reported),
            "ended_s_worst": max(ended),
        }
        typer.echo(json.dumps({of: facts}))


if __name__ == "__main__":
    typer.run(main)
