"""Times one filter step, state in → certified u out, beside other libraries.

``python benchmarks/filter_step.py``. Peers come with ``pip install -e .[peers]``; one that is not installed is
left out and named. The states lie along a closed loop of the reference scenario, mode ``both``. Before anything
is timed, every contender's answers are compared with ours. All run in one process, in rounds; within a round each
goes through all states, and each round begins with another one, so that a drift of the machine hits all alike.
Figures are medians over rounds.
"""

import gc
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from os import getloadavg
from pathlib import Path
from statistics import median
from time import perf_counter_ns
from typing import Annotated, Any

import numpy as np
import typer
from filter_contenders import (
    CVXPY_SOLVERS,
    CbfpyWithElastiqp,
    Contender,
    DaqpOnOurRows,
    Ours,
    ParametrisedCvxpy,
    Request,
)
from passafe_services.operator.sources.scenario_source import source_of
from passafe_services.scenarios.design import robot_of, sampled_plant_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from rich.console import Console
from rich.table import Table

from passafe.decision import Status

PACKAGES = ("passafe", "piqp", "casadi", "numpy", "cbfpy", "elastiqp", "jax", "cvxpy", "daqp")
SCOUTED = 50
"""States on which the solvers behind cvxpy are tried."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Timing:
    """What one contender took.

    Attributes:
        name: The contender.
        differs: What it does otherwise than ours.
        worst_difference: Largest distance of its u⁺ from ours, relative to 1 + ‖u⁺‖.
        tolerance: What was allowed.
        p50_us: Per call, µs: median over rounds of the round's median.
        p50_us_range: Smallest and largest of the rounds' medians.
        p99_us: Median over rounds of the round's 99th percentile.
        times_ours: Median over rounds of its p50 over ours in the same round.
        times_ours_range: Smallest and largest of those.
    """

    name: str
    differs: str
    worst_difference: float
    tolerance: float
    p50_us: float
    p50_us_range: tuple[float, float]
    p99_us: float
    times_ours: float
    times_ours_range: tuple[float, float]


def main(
    states: Annotated[int, typer.Option(min=10, max=5000, help="States along the closed loop.")] = 500,
    rounds: Annotated[int, typer.Option(min=3, max=200, help="Rounds.")] = 15,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of the table.")] = False,
) -> None:
    """Time one filter step beside cbfpy with elastiqp, cvxpy and DAQP, where installed."""
    scenario = load_scenario("notomista-cai-2020", {"filter.mode": "both"})
    ours = Ours(scenario)
    requests, active = sample_requests(scenario, ours, states)
    contenders, missing = installed_contenders(scenario, requests)
    field: list[Contender] = [ours, *contenders]
    differences = [worst_difference(ours, contender, requests) for contender in field]
    timings = compare(field, differences, time_in_rounds(field, requests, rounds))
    report = {
        "states": len(requests),
        "share_with_active_row": active,
        "rounds": rounds,
        "timings": [asdict(timing) for timing in timings],
        "not_installed": missing,
        "versions": versions(),
        "python": sys.version.split()[0],
        "cpu": processor(),
        "load_average_1min": getloadavg()[0],
    }
    if as_json:
        print(json.dumps(report, indent=2, ensure_ascii=False))
    else:
        show(report, timings)
    wrong = [timing.name for timing in timings if not timing.worst_difference <= timing.tolerance]
    if wrong:
        print(f"answers differ by more than allowed: {', '.join(wrong)}", file=sys.stderr)
        raise typer.Exit(1)


def sample_requests(scenario: Scenario, ours: Ours, states: int) -> tuple[list[Request], float]:
    """Return requests at equal intervals along a closed loop, and the share of them with an active row."""
    plant = sampled_plant_of(scenario, robot_of(scenario))
    m = plant.system.m
    source = source_of(scenario)
    x, u = tuple(scenario.plant.x0), (0.0,) * m
    steps = round(scenario.duration_s * scenario.rate_hz)
    chosen = set(np.linspace(0, steps - 1, states, dtype=int).tolist())
    requests, active = [], 0
    for step in range(steps):
        command = source.command(step * scenario.dt_s)
        request = Request(x, u, command.u_h, command.u_h_rate, 0.0)
        decision = ours.step(*request)
        if step in chosen:
            requests.append(request)
            active += decision.status is not Status.PASSED
        u = decision.u
        x = plant.advance(x, u).x
    return requests, active / len(requests)


def installed_contenders(scenario: Scenario, requests: Sequence[Request]) -> tuple[list[Contender], list[str]]:
    """Return the peers that are installed, and the names of the packages that are not."""
    contenders: list[Contender] = []
    missing = [name for name in ("cbfpy", "elastiqp", "cvxpy", "daqp") if find_spec(name) is None]
    if not {"cbfpy", "elastiqp"} & set(missing):
        contenders.append(CbfpyWithElastiqp(scenario))
    if "cvxpy" not in missing:
        contenders.append(fastest_cvxpy(scenario, requests[:: max(1, len(requests) // SCOUTED)]))
    if "daqp" not in missing:
        contenders.append(DaqpOnOurRows(scenario))
    return contenders, missing


def fastest_cvxpy(scenario: Scenario, requests: Sequence[Request]) -> Contender:
    """Return cvxpy with the solver that is fastest on some of the states."""
    installed: list[str] = import_module("cvxpy").installed_solvers()
    candidates = [ParametrisedCvxpy(scenario, solver) for solver in CVXPY_SOLVERS if solver in installed]
    trials = [time_in_rounds([candidate], requests, 3) for candidate in candidates]
    return candidates[min(range(len(candidates)), key=lambda i: float(np.median(trials[i])))]


def worst_difference(ours: Ours, contender: Contender, requests: Sequence[Request]) -> float:
    """Return the largest distance of a contender's u⁺ from ours, relative to 1 + ‖u⁺‖."""
    worst = 0.0
    for request in requests:
        expected = np.array(ours.step(*request).u)
        got = np.array(contender.answer(contender.step(*contender.prepare(request))))
        worst = max(worst, float(np.linalg.norm(got - expected) / (1 + np.linalg.norm(expected))))
    return worst


def time_in_rounds(
    contenders: Sequence[Contender], requests: Sequence[Request], rounds: int
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the time of every call, µs, shape (rounds, contenders, requests), after one round of warm-up."""
    calls = [[(c.step, c.prepare(request)) for request in requests] for c in contenders]
    times = np.zeros((rounds + 1, len(contenders), len(requests)))
    gc.collect()
    gc.disable()
    for turn in range(rounds + 1):
        for place in range(len(contenders)):
            which = (turn + place) % len(contenders)
            times[turn, which] = time_calls(calls[which])
        gc.collect()
    gc.enable()
    return times[1:]


def time_calls(calls: Sequence[tuple[Callable[..., Any], tuple[Any, ...]]]) -> list[float]:
    """Return the time of each call, µs."""
    times = []
    for step, arguments in calls:
        begin = perf_counter_ns()
        step(*arguments)
        times.append((perf_counter_ns() - begin) / 1e3)
    return times


def compare(
    contenders: Sequence[Contender],
    differences: Sequence[float],
    times: np.ndarray[Any, np.dtype[np.float64]],
) -> list[Timing]:
    """Return the figures of every contender; the first is ours."""
    p50, p99 = np.percentile(times, [50, 99], axis=2)
    ratio = p50 / p50[:, :1]
    return [
        Timing(
            name=contender.name,
            differs=contender.differs,
            worst_difference=differences[i],
            tolerance=contender.tolerance,
            p50_us=median(p50[:, i]),
            p50_us_range=(min(p50[:, i]), max(p50[:, i])),
            p99_us=median(p99[:, i]),
            times_ours=median(ratio[:, i]),
            times_ours_range=(min(ratio[:, i]), max(ratio[:, i])),
        )
        for i, contender in enumerate(contenders)
    ]


def versions() -> dict[str, str]:
    """Return the versions of what is installed of the packages that matter."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def processor() -> str:
    """Return the processor's name where the system tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")


def show(report: dict[str, Any], timings: Sequence[Timing]) -> None:
    """Print the table."""
    share, load = report["share_with_active_row"], report["load_average_1min"]
    states = f"{report['states']} states, {share:.0%} with an active row"
    title = f"One filter step: {states}, {report['rounds']} rounds"
    table = Table(title=title)
    for column in ("", "p50 µs (min–max)", "p99 µs", "times ours (min–max)", "‖Δu⁺‖/(1+‖u⁺‖)"):
        table.add_column(column, justify="right" if column else "left")
    for t in timings:
        p50 = f"{t.p50_us:.1f} ({t.p50_us_range[0]:.1f}–{t.p50_us_range[1]:.1f})"
        ratio = f"{t.times_ours:.2f} ({t.times_ours_range[0]:.2f}–{t.times_ours_range[1]:.2f})"
        difference = f"{t.worst_difference:.1e} (≤ {t.tolerance:.0e})"
        table.add_row(t.name, p50, f"{t.p99_us:.1f}", ratio, difference)
    console = Console(width=max(100, Console().width))
    console.print(table)
    for t in timings:
        console.print(f"{t.name}: {t.differs}", highlight=False)
    installed = ", ".join(f"{name} {number}" for name, number in report["versions"].items())
    console.print(f"{report['cpu']}, load {load:.1f}; python {report['python']}, {installed}", highlight=False)
    if report["not_installed"]:
        console.print(f"not installed, not compared: {', '.join(report['not_installed'])}")


if __name__ == "__main__":
    typer.run(main)
