"""Kills processes of a running system at random moments: ``python benchmarks/live_kills.py``.

``passafe demo --restart`` runs while a script pushes the robot against its obstacles. At random moments filter, router
or operator is killed, or the router stands still for 0.05 to 1 s, as if the network were cut. From the logs: how long
until the plant noticed and until it took inputs again, and the lowest h at samples and between them.
"""

import json
import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import typer
from passafe_protocol.codec import decode
from passafe_protocol.messages import Header, Message, PlantPhase, PlantState
from passafe_protocol.topics import COMMAND, STATE, TICK, Topic
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.errors import BusError
from passafe_services.loop.process_spec import RestartPolicy
from passafe_services.loop.realtime import RECORDER_PRIORITY, request_realtime
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.sequence_breaks import SequenceBreak, sequence_breaks
from passafe_services.tools.review.verdict import Verdict
from rich.console import Console
from rich.progress import track
from rich.table import Table

# Back and forth through the obstacles, further than the walls are, so that the robot runs into something all the time.
SWEEPS = {
    "notomista-cai-2020": {"amplitude": [25.0, 8.0], "phase_rad": [1.6, 0.0], "frequency_hz": 0.4},
    "walls-and-disks": {"amplitude": [16.0, 11.0], "phase_rad": [0.0, 1.0], "frequency_hz": 0.3},
}
KINDS = ("filter", "router", "operator", "outage")
START_S = 180.0
PATIENCE_S = 60.0
"""How long a disarmed robot may take to be armed again: a loaded machine starts processes slowly."""
QUIET_S = (0.3, 3.0)
OUTAGE_S = (0.05, 1.0)
BETWEEN_S = 0.2
"""How long after the end of an outage a state counts as one of after it."""


class NoRobotError(Exception):
    """A demo that did not come up."""


@dataclass(frozen=True, kw_only=True)
class Kill:
    """One kill or outage.

    Attributes:
        number: Counted from 1.
        demo: Which demo it happened in, from 1.
        kind: What was killed, or ``outage``.
        outage_s: How long the router stood still.
        wall_ns: When.
        armed: Whether the plant was seen to apply inputs again, made after that, within ``PATIENCE_S``.
        at_s: Plant time of the first missing input after that, s; ``None``: the robot was never disarmed.
        noticed_s: From then until an input was missing.
        fail_safe_s: From then until the fail-safe law was in force.
        armed_s: From then until an input was applied again.
    """

    number: int
    demo: int
    kind: str
    outage_s: float
    wall_ns: int
    armed: bool
    at_s: float | None = None
    noticed_s: float | None = None
    fail_safe_s: float | None = None
    armed_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class Demo:
    """What the log of one demo says; see ``Verdict`` for the figures."""

    number: int
    scenario: str
    log: str
    duration_s: float
    h_min: float
    h_min_at_samples: float
    tank_min_j: float
    disarmings: int
    disarmed_s: float
    states_missing: int
    ends_armed: bool


class Running:
    """A demo that runs, and what is heard of it."""

    def __init__(self, process: "subprocess.Popen[str]", bus: Bus) -> None:
        self.process = process
        self.bus = bus
        self._readers = {topic: bus.reader(topic) for topic in (STATE, COMMAND, TICK)}

    def pid(self, name: str) -> int:
        """Process id of a supervised process."""
        for pid in self.children():
            if name in Path(f"/proc/{pid}/cmdline").read_bytes().decode().split("\0"):
                return pid
        raise ProcessLookupError(name)

    def children(self) -> list[int]:
        """Process ids of all supervised processes."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(pid) for pid in children.read_text(encoding="ascii").split()]

    def heard(self, topic: Topic, wanted: Callable[[Header, Message], bool], patience_s: float = PATIENCE_S) -> bool:
        """Wait for a message; tell whether one came in time."""
        end = time.monotonic() + patience_s
        while time.monotonic() < end and self.process.poll() is None:
            if any(wanted(*decode(topic, data)) for data in self._readers[topic].drain()):
                return True
            time.sleep(0.005)
        return False

    def newest_epoch(self, topic: Topic) -> int:
        """Session of whoever publishes a topic now."""
        epochs: list[int] = []
        self.heard(topic, lambda header, _: epochs.append(header.epoch) or True)
        return max(epochs, default=0)


def is_running(body: Message) -> bool:
    """Tell whether a plant state is one with an input of the filter in force."""
    return isinstance(body, PlantState) and body.phase is PlantPhase.RUNNING


def strike(running: Running, kind: str, outage_s: float) -> tuple[int, bool]:
    """Do it; return when it was done and whether the plant took inputs again that were made after that."""
    before = {"filter": running.newest_epoch(TICK), "operator": running.newest_epoch(COMMAND)}
    router = running.bus.router
    pid = running.pid("router" if kind == "outage" else kind)
    wall_ns = time.time_ns()
    if kind == "outage":
        os.kill(pid, signal.SIGSTOP)
        time.sleep(outage_s)
        os.kill(pid, signal.SIGCONT)
        since_ns = time.time_ns() + round(BETWEEN_S * 1e9)
        return wall_ns, running.heard(STATE, lambda head, body: head.wall_ns > since_ns and is_running(body))
    os.kill(pid, signal.SIGKILL)
    match kind:
        case "filter":
            armed = running.heard(
                STATE,
                lambda _, body: (
                    isinstance(body, PlantState) and body.input_epoch > before["filter"] and is_running(body)
                ),
            )
        case "router":
            armed = running.heard(
                STATE,
                lambda head, body: (
                    running.bus.router not in {"", router} and head.wall_ns > wall_ns + 50_000_000 and is_running(body)
                ),
            )
        case _:
            back = running.heard(COMMAND, lambda header, _: header.epoch > before["operator"])
            since_ns = time.time_ns()
            armed = back and running.heard(STATE, lambda head, body: head.wall_ns > since_ns and is_running(body))
    return wall_ns, armed


@contextmanager
def running_demo(scenario: Path, out: Path, rate_hz: float) -> Iterator[Running]:
    """Run a demo; whatever happens, nothing of it is left."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = int(server.getsockname()[1])
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--restart", "--headless"]
    arguments = ["--scenario", str(scenario), "--out", str(out), "--router-port", str(port), "--rate", str(rate_hz)]
    with (out / "demo.txt").open("w", encoding="utf-8") as lines:
        process = subprocess.Popen([*command, *arguments], stdout=lines, stderr=lines, text=True)  # noqa: S603 - ours
        request_realtime(RECORDER_PRIORITY)  # what is started from now on would inherit it
        try:
            with open_bus(RouterEndpoint(port=port), timeout_s=START_S) as bus:
                running = Running(process, bus)
                if not running.heard(STATE, lambda _, body: is_running(body), START_S):
                    raise NoRobotError(f"no robot moved; see {out / 'demo.txt'}")
                yield running
                process.send_signal(signal.SIGINT)
            end = time.monotonic() + PATIENCE_S
            while running.children() and time.monotonic() < end:
                time.sleep(0.1)
        finally:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            process.kill()  # its log is finished and judged here; if not, the lifelines of its children end with it
            process.wait()


def strike_again_and_again(
    running: Running, chance: random.Random, numbers: range, demo: int, say: Callable[[str], object]
) -> list[Kill]:
    """Strike once for each number, at random; stop early where the robot is not armed again."""
    kills: list[Kill] = []
    for number in numbers:
        time.sleep(chance.uniform(*QUIET_S))
        recent = [kill.kind for kill in kills if time.time_ns() - kill.wall_ns < RestartPolicy().within_s * 1e9]
        kind = chance.choice([kind for kind in KINDS if kind == "outage" or recent.count(kind) < RestartPolicy().most])
        outage_s = chance.uniform(*OUTAGE_S) if kind == "outage" else 0.0
        wall_ns, armed = strike(running, kind, outage_s)
        kills.append(Kill(number=number, demo=demo, kind=kind, outage_s=outage_s, wall_ns=wall_ns, armed=armed))
        say(f"{number}: {kind}, {'armed again' if armed else f'not armed again within {PATIENCE_S:g} s'}")
        if not armed:
            break
    time.sleep(1.0)
    return kills


def timed(kills: list[Kill], found: list[SequenceBreak]) -> list[Kill]:
    """Add to each kill what the log says of the first disarming between it and the next."""
    told = []
    for index, kill in enumerate(kills):
        end_ns = kills[index + 1].wall_ns if index + 1 < len(kills) else sys.maxsize
        mine = [one for one in found if kill.wall_ns <= one.wall_ns < end_ns]
        if mine:
            since_s = lambda ns, begun=kill.wall_ns: None if ns is None else (ns - begun) * 1e-9  # noqa: E731 - local
            first = mine[0]
            kill = replace(  # noqa: PLW2901 - the same kill, told more of
                kill,
                at_s=first.at_s,
                noticed_s=since_s(first.wall_ns),
                fail_safe_s=since_s(first.fail_safe_wall_ns),
                armed_s=since_s(first.armed_wall_ns),
            )
        told.append(kill)
    return told


def judge(log: RunLog, number: int) -> Demo:
    """Return the figures of one log."""
    verdict = Verdict.of(log, CoreEvaluator(log.identity.scenario))
    states = log.of(PlantState)
    figures = (verdict.h_min, verdict.h_min_at_samples, verdict.tank_min_j)
    h_min, h_min_at_samples, tank_min_j = (float("nan") if figure is None else figure for figure in figures)
    return Demo(
        number=number,
        scenario=verdict.scenario,
        log=str(log.path),
        duration_s=verdict.duration_s,
        h_min=h_min,
        h_min_at_samples=h_min_at_samples,
        tank_min_j=tank_min_j,
        disarmings=verdict.disarmings,
        disarmed_s=verdict.disarmed_s,
        states_missing=log.counts["state"].gaps,
        ends_armed=bool(states) and is_running(states[-1].body),
    )


def run_demo(
    name: str, out: Path, number: int, numbers: range, seed: int, rate_hz: float, say: Callable[[str], object]
) -> tuple[Demo, list[Kill]]:
    """Run one demo with its kills and judge its log."""
    folder = out / f"demo-{number}"
    folder.mkdir(parents=True)
    source = {"kind": "sine", **SWEEPS[name]}
    scenario = load_scenario(name, {"operator.source": source, "filter.mode": "both"})
    file = folder / "scenario.json"
    file.write_text(scenario.model_dump_json(indent=2), encoding="utf-8")
    chance = random.Random(f"{seed}/{number}")  # noqa: S311 - reproducible, not secret
    with running_demo(file, folder, rate_hz) as running:
        kills = strike_again_and_again(running, chance, numbers, number, say)
    [path] = [path for path in folder.glob("*.mcap") if not path.name.endswith(".torn.mcap")]
    log = RunLog.read(path)
    return judge(log, number), timed(kills, sequence_breaks(log.of(PlantState)))


def tables(demos: list[Demo], kills: list[Kill]) -> Iterator[Table]:
    """Yield what is printed."""
    seconds = lambda value: "" if value is None else f"{value:.3f} s"  # noqa: E731 - local
    table = Table("kill", "demo", "what", "at", "input missing", "fail-safe", "armed again", title="since the kill")
    for kill in kills:
        what = kill.kind if kill.kind != "outage" else f"router stood still {kill.outage_s:.2f} s"
        times = (kill.at_s, kill.noticed_s, kill.fail_safe_s, kill.armed_s)
        armed = [seconds(value) for value in times] if kill.at_s is not None else ["never disarmed", "", "", ""]
        if not kill.armed:
            armed[-1] = "[bold red]NOT AGAIN[/]"
        table.add_row(str(kill.number), str(kill.demo), what, *armed)
    yield table
    table = Table("demo", "scenario", "plant time", "h_min", "at samples", "tank min", "disarmed", "states missing")
    for demo in demos:
        low = f"[bold red]{demo.h_min:.2e}[/]" if not demo.h_min >= 0 else f"{demo.h_min:.2e}"
        disarmed = f"{demo.disarmings} times, {demo.disarmed_s:.1f} s"
        rest = (f"{demo.h_min_at_samples:.2e}", f"{demo.tank_min_j:.3f} J", disarmed, str(demo.states_missing))
        table.add_row(str(demo.number), demo.scenario, f"{demo.duration_s:.1f} s", low, *rest)
    yield table


def report(demos: list[Demo], kills: list[Kill]) -> dict[str, Any]:
    """Return everything found, for ``--json``."""
    return {
        "kills": [asdict(kill) for kill in kills],
        "demos": [asdict(demo) for demo in demos],
        "h_min": min((demo.h_min for demo in demos), default=None),
        "tank_min_j": min((demo.tank_min_j for demo in demos), default=None),
        "armed_again": sum(kill.armed for kill in kills),
    }


def main(
    kills: Annotated[int, typer.Option(min=1, help="Kills and outages in all.")] = 50,
    per_demo: Annotated[
        int, typer.Option(min=1, help="After so many a new demo is started, of the other scenario.")
    ] = 10,
    seed: Annotated[int, typer.Option(help="Decides moments, victims and lengths of outages.")] = 0,
    rate: Annotated[float, typer.Option(min=50.0, max=1000.0, help="Ticks per second, Hz.")] = 1000.0,
    out: Annotated[Path | None, typer.Option(help="Folder that keeps the logs; thrown away if not given.")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", help="File for all figures as JSON.")] = None,
) -> None:
    """Kill filter, router or operator, or stop the router for a while, at random moments of running demos.

    Exits with 1 if h was negative anywhere, at or between samples, or if the robot was not armed again after a kill.
    """
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # nothing is left behind then either
    console = Console(width=None if sys.stdout.isatty() else 140)
    demos: list[Demo] = []
    done: list[Kill] = []
    names = list(SWEEPS)
    with TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        firsts = range(1, kills + 1, per_demo)
        for number, first in enumerate(track(firsts, "demos", console=console), start=1):
            numbers = range(first, min(first + per_demo, kills + 1))
            name = names[(number - 1) % len(names)]
            try:
                demo, struck = run_demo(name, folder, number, numbers, seed, rate, console.print)
            except (NoRobotError, BusError) as error:
                console.print(f"demo {number}: {error}")
                continue
            demos.append(demo)
            done += struck
    for table in tables(demos, done):
        console.print(table)
    found = report(demos, done)
    if json_file is not None:
        json_file.write_text(json.dumps(found, indent=2), encoding="utf-8")
    is_safe = all(demo.h_min >= 0 for demo in demos)  # a NaN is not
    went_on = found["armed_again"] == kills
    console.print(f"h ≥ 0 {'always' if is_safe else 'NOT ALWAYS'}; armed again {found['armed_again']} of {kills} times")
    raise typer.Exit(0 if is_safe and went_on else 1)


if __name__ == "__main__":
    typer.run(main)
