"""Presses the emergency stop of a running system while its processes fail: ``python benchmarks/live_stops.py``.

``passafe demo --restart`` runs. In every trial something fails, or nothing does; then a console presses the emergency
stop, and later clears it. Read from the logs, on the clock that all processes of a machine share: how long from the
press until the fail-safe law was in force and the stop latched, and whether any input moved the robot before the clear.
"""

import os
import random
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Final

import numpy as np
import typer
from live_demo import LiveDemo, NoRobotError, is_running, live_demo
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_protocol.topics import STATE
from passafe_services.log.continuity import LoggedMessage
from passafe_services.loop.bus import open_bus
from passafe_services.loop.errors import BusError, PlantSilentError
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.stop_console import StopConsole
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.run_log import RunLog
from report import AsJson, Report, Smallest
from rich.console import Console
from rich.progress import track

PROMPT_MS: Final = 50.0
"""Longest time from press to fail-safe on an idle network, 99th percentile."""

LEAST_TRIALS: Final = 20
"""Trials from which on a percentile is judged."""

SUSPENDED: Final = {
    "nothing": (),
    "filter stands still": ("filter",),
    "operator stands still": ("operator",),
    "recorder stands still": ("recorder",),
    "operator and filter stand still": ("operator", "filter"),
    "router stands still": ("router",),
    "plant stands still": ("plant",),
}
"""What fails, and the processes that are suspended for it, until 0.05 to 0.5 s after the press."""

KILLED: Final = {"filter is killed": "filter", "operator is killed": "operator", "router is killed": "router"}
NETWORK: Final = ("router stands still", "plant stands still", "router is killed")
"""Failures of the way to the plant or of the plant itself: the time of the press includes theirs."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One press.

    Attributes:
        what: What failed.
        pressed_ns: Time of the press, monotonic, ns.
        cleared_ns: Time at which the clear was requested.
        is_acknowledged: Whether the console received the plant's answer.
        resumed: Whether inputs moved the robot again after the clear.
    """

    what: str
    pressed_ns: int
    cleared_ns: int
    is_acknowledged: bool
    resumed: bool


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Outcome of a trial by its log: times since the press, ms, and whether it was effective."""

    what: str
    fail_safe_ms: float
    latched_ms: float
    is_effective: bool


def main(
    trials: Annotated[int, typer.Option(min=1, help="Presses in all.")] = 200,
    per_demo: Annotated[int, typer.Option(min=1, help="After so many a new demo is started.")] = 25,
    seed: Annotated[int, typer.Option(help="Decides moments and lengths of failures.")] = 0,
    rate: Annotated[float, typer.Option(min=50.0, max=1000.0, help="Ticks per second, Hz.")] = 500.0,
    only: Annotated[str | None, typer.Option(help="Only this failure, such as `nothing`.")] = None,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Press the emergency stop of running demos while processes fail, and clear it again.

    Exits with 1 if a press was not effective, or if its 99th percentile on an idle network is above 50 ms.
    """
    kinds = [only] if only else [*SUSPENDED, *KILLED]
    if smallest:
        trials, rate, kinds = 2, 200.0, ["nothing", "operator and filter stand still"]
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # nothing is left behind then either
    report = Report(
        title=f"{trials} presses at {rate:g} Hz, seed {seed}; ms from the press",
        columns=("what failed", "trials", "effective", "fail-safe p50", "p99", "largest", "latched, largest"),
    )
    outcomes: list[Outcome] = []
    with TemporaryDirectory() as scratch:
        for first in track(range(0, trials, per_demo), "demos", console=Console(stderr=True)):
            chance = random.Random(f"{seed}/{first}")  # noqa: S311 - reproducible, not secret
            wanted = [kinds[k % len(kinds)] for k in range(first, min(first + per_demo, trials))]
            folder = Path(scratch) / str(first)
            try:
                outcomes += pressed_demo(folder, wanted, chance, rate)
            except (NoRobotError, BusError, PlantSilentError) as error:
                report.failures.append(f"trials {first + 1} to {first + len(wanted)}: {error}")
    judge(outcomes, trials, report)
    report.finish(as_json=as_json)


def pressed_demo(folder: Path, wanted: Sequence[str], chance: random.Random, rate_hz: float) -> list[Outcome]:
    """Run one demo with its presses; return what its log shows."""
    folder.mkdir(parents=True)
    scenario = load_scenario("notomista-cai-2020")
    file = folder / "scenario.json"
    file.write_text(scenario.model_dump_json(indent=2), encoding="utf-8")
    with live_demo(file, folder, rate_hz) as demo, open_bus(RouterEndpoint.of_demo(demo.port, "console")) as bus:
        console = StopConsole(bus, epoch=time.time_ns(), answer_s=30.0)
        trials = [trial(demo, console, what, chance) for what in wanted]
    [path] = [path for path in folder.glob("*.mcap") if not path.name.endswith(".torn.mcap")]
    states = RunLog.read(path).of(PlantState)
    return [outcome(each, states) for each in trials]


def trial(demo: LiveDemo, console: StopConsole, what: str, chance: random.Random) -> Trial:
    """Let something fail, press the stop, mend the failure, clear the stop, and wait until the robot moves again."""
    time.sleep(chance.uniform(0.2, 0.6))
    still = [demo.pid(name) for name in SUSPENDED.get(what, ())]
    for pid in still:
        os.kill(pid, signal.SIGSTOP)
    if what in KILLED:
        os.kill(demo.pid(KILLED[what]), signal.SIGKILL)
    time.sleep(chance.uniform(0.0, 0.05))
    pressed_ns = time.monotonic_ns()
    until_s = time.monotonic() + chance.uniform(0.05, 0.5)
    if what in NETWORK:  # nobody answers before it is mended
        time.sleep(until_s - time.monotonic())
        resume(still)
    is_acknowledged = True
    try:
        console.press(what)
    except PlantSilentError:
        is_acknowledged = False
    time.sleep(max(until_s - time.monotonic(), 0.0))
    resume(still)
    time.sleep(0.3)
    cleared_ns = time.monotonic_ns()
    console.clear("end of the trial")
    resumed = demo.receives(STATE, lambda head, body: head.sent_ns > cleared_ns and is_running(body))
    return Trial(
        what=what, pressed_ns=pressed_ns, cleared_ns=cleared_ns, is_acknowledged=is_acknowledged, resumed=resumed
    )


def resume(pids: list[int]) -> None:
    """Let suspended processes go on; once for each."""
    while pids:
        os.kill(pids.pop(), signal.SIGCONT)


def outcome(each: Trial, states: Sequence[LoggedMessage[PlantState]]) -> Outcome:
    """Return what the log shows of a trial."""
    during = [state for state in states if each.pressed_ns <= state.header.started_ns <= each.cleared_ns]
    latched = [state for state in during if state.body.stop]
    law = [state for state in during if state.body.phase is PlantPhase.FAIL_SAFE]
    is_kept = all(state.body.phase is PlantPhase.FAIL_SAFE for state in latched)
    return Outcome(
        what=each.what,
        fail_safe_ms=since_ms(each, law),
        latched_ms=since_ms(each, latched),
        is_effective=bool(latched) and is_kept and each.is_acknowledged and each.resumed,
    )


def since_ms(each: Trial, states: Sequence[LoggedMessage[PlantState]]) -> float:
    """Return the time from the press to the first of these states, ms; infinite without one."""
    return min(((state.header.started_ns - each.pressed_ns) / 1e6 for state in states), default=float("inf"))


def judge(outcomes: Sequence[Outcome], trials: int, report: Report) -> None:
    """Add a row for each failure, and what is wrong."""
    for what in dict.fromkeys(each.what for each in outcomes):
        found = [each for each in outcomes if each.what == what]
        law_ms = [each.fail_safe_ms for each in found]
        effective = sum(each.is_effective for each in found)
        p50, p99 = np.percentile(law_ms, [50, 99])
        latched = max(each.latched_ms for each in found)
        numbers = [f"{value:.1f}" for value in (p50, p99, max(law_ms), latched)]
        report.rows.append((what, str(len(found)), str(effective), *numbers))
    effective = sum(each.is_effective for each in outcomes)
    if effective < trials:
        report.failures.append(f"presses that were effective: got {effective}, allowed {trials}")
    idle = [each.latched_ms for each in outcomes if each.what not in NETWORK]
    if not idle:
        return
    p99_ms = float(np.percentile(idle, 99))
    report.notes.append(
        f"{effective} of {trials} effective; {len(idle)} with an idle network: latched p99 {p99_ms:.1f} ms"
    )
    if len(idle) >= LEAST_TRIALS and p99_ms > PROMPT_MS:
        report.failures.append(f"p99 from press to latch, ms: got {p99_ms:.1f}, allowed {PROMPT_MS:g}")


if __name__ == "__main__":
    typer.run(main)
