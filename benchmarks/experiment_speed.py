"""How fast a sweep is, and what a second worker is worth: ``python benchmarks/experiment_speed.py``.

The same runs with one worker and with two, in turn. A rate is the slope of the results' number over their time (least
squares: they come in portions), without the first portions of every process, in which it starts and derives. The
machine's other load is printed beside it: two workers are worth two only where two processors are free.
"""

import json
import os
import sys
from dataclasses import asdict, dataclass
from statistics import linear_regression, median
from time import perf_counter
from typing import Annotated

import typer
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.experiment.load import Study, experiment_from
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.worker_pool import local_processes, results
from rich.console import Console
from rich.table import Table

LINKS = ("plant-to-filter", "filter-to-plant")


@dataclass(frozen=True, kw_only=True, slots=True)
class Speed:
    """Figures of one crew.

    Attributes:
        workers: How many processes.
        runs_per_s: Runs finished per second once all processes work, of every repetition.
        times_real_time: Plant time over wall-clock time, median.
        start_s: From nothing to the first result of every process, median, s.
    """

    workers: int
    runs_per_s: tuple[float, ...]
    times_real_time: float
    start_s: float


def main(
    runs: Annotated[int, typer.Option(min=20, help="Runs of each measurement.")] = 60,
    duration: Annotated[float, typer.Option(min=0.1, help="Plant time of each run, s.")] = 10.0,
    repetitions: Annotated[int, typer.Option(min=1, help="Measurements with each number of workers, in turn.")] = 3,
    scenario: Annotated[str, typer.Option(help="Scenario, by name or file.")] = "notomista-cai-2020",
    rate: Annotated[float, typer.Option(min=1.0, max=1000.0, help="Ticks per second, Hz.")] = 1000.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of the table.")] = False,
) -> None:
    """Time a sweep with delay, jitter and loss on both of the robot's links, random starts."""
    study = sweep(scenario, runs, duration, rate)
    measured: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
    for _ in range(repetitions):
        for workers, found in measured.items():
            found.append(timed(study, workers))
    speeds = [
        Speed(
            workers=workers,
            runs_per_s=tuple(rate for rate, _ in found),
            times_real_time=duration * median(rate for rate, _ in found),
            start_s=median(start_s for _, start_s in found),
        )
        for workers, found in measured.items()
    ]
    gain = median(speeds[1].runs_per_s) / median(speeds[0].runs_per_s)
    load = os.getloadavg()[0]
    if as_json:
        facts = {"scenario": scenario, "runs": runs, "duration_s": duration, "rate_hz": rate}
        facts |= {"python": sys.version.split()[0]}
        facts |= {"load_average_1min": load, "two_over_one": gain, "crews": [asdict(speed) for speed in speeds]}
        print(json.dumps(facts, indent=2))
        return
    show(speeds, gain, f"Sweep, {scenario}, {runs} runs of {duration:g} s at {rate:g} Hz, load {load:.1f}", duration)


def sweep(scenario: str, runs: int, duration_s: float, rate_hz: float) -> Study:
    """Return a study of so many runs, each over a bad network of its own."""
    links = {"delay_s": 0.1, "jitter_s": 0.01, "loss": 0.05}
    content = {
        "schema_version": 1,
        "name": "speed",
        "title": "Speed of a sweep",
        "scenario": scenario,
        "start": "random",
        "seeds": {"count": runs},
        "overrides": {"duration_s": duration_s, "rate_hz": rate_hz} | {f"links.{name}": links for name in LINKS},
    }
    return Study(
        experiment=experiment_from(content, "benchmark"),
        scenario=load_scenario(scenario).model_dump(mode="json", exclude_unset=True),
    )


def timed(study: Study, workers: int) -> tuple[float, float]:
    """Return runs per second once all processes work, and how long it took until they did, s."""
    plan = Plan(study.experiment)
    begun_s = perf_counter()
    with local_processes(workers) as crew:
        at_s = [perf_counter() - begun_s for _ in results(plan, study, crew, lambda: False)]
        portions = workers * crew.portion
    steady = range(2 * portions, len(at_s))
    return linear_regression(at_s[2 * portions :], steady).slope, at_s[portions - 1]


def show(speeds: list[Speed], gain: float, title: str, duration_s: float) -> None:
    """Print the table."""
    table = Table("workers", "runs/s: min", "median", "max", "× real time", "1000 runs take", "start", title=title)
    for speed in speeds:
        rates = speed.runs_per_s
        middle = median(rates)
        figures = [f"{min(rates):.2f}", f"{middle:.2f}", f"{max(rates):.2f}", f"{duration_s * middle:.0f}"]
        table.add_row(str(speed.workers), *figures, f"{speed.start_s + 1000 / middle:.0f} s", f"{speed.start_s:.1f} s")
    console = Console(width=max(100, Console().width))
    console.print(table)
    console.print(f"two workers over one: {gain:.2f}")


if __name__ == "__main__":
    typer.run(main)
