"""Kills processes of a running system at random moments: ``python benchmarks/live_kills.py``.

``passafe demo --restart`` runs while a script pushes the robot against its obstacles. At random moments filter, router
or operator is killed, or the router stands still for 0.05 to 1 s, as if the network were cut. Read from the logs: how
long until the plant missed an input and until it applied inputs again, and the lowest h at samples and between them.
"""

import random
import signal
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
from live_demo import NoRobotError, live_demo
from live_strikes import Strike, strike_at_random, with_breaks
from passafe_protocol.messages import PlantState
from passafe_services.loop.errors import BusError
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.sequence_breaks import sequence_breaks
from passafe_services.tools.review.verdict import Verdict
from report import AsJson, Report, Smallest
from rich.console import Console
from rich.progress import track

# Back and forth through the obstacles, further than the walls are, so that the robot runs into something all the time.
SWEEPS = {
    "notomista-cai-2020": {"amplitude": [25.0, 8.0], "phase_rad": [1.6, 0.0], "frequency_hz": 0.4},
    "walls-and-disks": {"amplitude": [16.0, 11.0], "phase_rad": [0.0, 1.0], "frequency_hz": 0.3},
}


def main(
    kills: Annotated[int, typer.Option(min=1, help="Kills and outages in all.")] = 50,
    per_demo: Annotated[
        int, typer.Option(min=1, help="After so many a new demo is started, of the other scenario.")
    ] = 10,
    seed: Annotated[int, typer.Option(help="Decides moments, victims and lengths of outages.")] = 0,
    rate: Annotated[float, typer.Option(min=50.0, max=1000.0, help="Ticks per second, Hz.")] = 1000.0,
    out: Annotated[Path | None, typer.Option(help="Folder that keeps the logs; thrown away if not given.")] = None,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Kill filter, router or operator, or stop the router for a while, at random moments of running demos.

    Exits with 1 if h was negative anywhere, at or between samples, or if the robot did not resume after a kill.
    """
    if smallest:
        kills, rate = 1, 200.0
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # nothing is left behind then either
    report = Report(
        title=f"{kills} kills at {rate:g} Hz, seed {seed}; times since the kill",
        columns=("kill", "demo", "what", "at", "input missing", "fail-safe", "resumed"),
    )
    console, names, resumed = Console(stderr=True), list(SWEEPS), 0
    with TemporaryDirectory() as scratch:
        firsts = range(1, kills + 1, per_demo)
        for number, first in enumerate(track(firsts, "demos", console=console), start=1):
            name, folder = names[(number - 1) % len(names)], (out or Path(scratch)) / f"demo-{number}"
            chance = random.Random(f"{seed}/{number}")  # noqa: S311 - reproducible, not secret
            numbers = range(first, min(first + per_demo, kills + 1))
            try:
                log, strikes = struck_demo(name, folder, number, numbers, chance, rate, console)
            except (NoRobotError, BusError) as error:
                report.failures.append(f"demo {number}: {error}")
                continue
            judge(log, number, strikes, report)
            resumed += sum(strike.resumed for strike in strikes)
    report.notes.append(f"resumed {resumed} of {kills} times")
    if resumed < kills:
        report.failures.append(f"kills after which the robot resumed: got {resumed}, allowed {kills}")
    report.finish(as_json=as_json)


def struck_demo(
    name: str, folder: Path, number: int, numbers: range, chance: random.Random, rate_hz: float, console: Console
) -> tuple[RunLog, list[Strike]]:
    """Run one demo with its kills; return its log and its kills, with the times that the log shows."""
    folder.mkdir(parents=True)
    source = {"kind": "sine", **SWEEPS[name]}
    scenario = load_scenario(name, {"operator.source": source, "filter.mode": "both"})
    file = folder / "scenario.json"
    file.write_text(scenario.model_dump_json(indent=2), encoding="utf-8")
    with live_demo(file, folder, rate_hz) as demo:
        strikes = strike_at_random(demo, chance, numbers, number, console.print)
    [path] = [path for path in folder.glob("*.mcap") if not path.name.endswith(".torn.mcap")]
    log = RunLog.read(path)
    return log, with_breaks(strikes, sequence_breaks(log.of(PlantState)))


def judge(log: RunLog, number: int, strikes: list[Strike], report: Report) -> None:
    """Report one demo's kills and what its log shows; h < 0 is a failure."""
    verdict = Verdict.of(log, CoreEvaluator(log.identity.scenario))
    report.rows += map(row, strikes)
    report.notes.append(note(number, verdict, log))
    if verdict.h_min is None or not verdict.h_min >= 0:  # a NaN is not
        report.failures.append(f"lowest h of demo {number}: got {verdict.h_min}, allowed 0 or more")


def row(strike: Strike) -> tuple[str, ...]:
    """Return a row of the table."""
    what = strike.kind if strike.kind != "outage" else f"router stood still {strike.outage_s:.2f} s"
    times = (strike.at_s, strike.missed_after_s, strike.fail_safe_after_s, strike.resumed_after_s)
    cells = ["" if time_s is None else f"{time_s:.3f} s" for time_s in times]
    if strike.at_s is None:
        cells[0] = "no break"
    if not strike.resumed:
        cells[-1] = "NEVER"
    return str(strike.number), str(strike.demo), what, *cells


def note(number: int, verdict: Verdict, log: RunLog) -> str:
    """Return a summary of one demo's log."""
    return (
        f"demo {number}, {verdict.scenario}, {verdict.duration_s:.1f} s: lowest h {verdict.h_min}, "
        f"at samples {verdict.h_min_at_samples}, lowest tank {verdict.tank_min_j} J, "
        f"{verdict.sequence_breaks} sequence breaks, {verdict.without_input_s:.1f} s in all, "
        f"{log.counts['state'].gaps} states missing"
    )


if __name__ == "__main__":
    typer.run(main)
