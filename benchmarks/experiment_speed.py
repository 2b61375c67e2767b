"""Measures how fast a sweep is, and what a second worker is worth: ``python benchmarks/experiment_speed.py``.

The same runs with one worker and with two, in turn. A rate is the slope of the results' number over their time (least
squares: they come in chunks), without the first chunks of every process, in which it starts and compiles. Two workers
are worth two only where two processors are free.
"""

from contextlib import closing
from functools import partial
from statistics import linear_regression, median
from time import perf_counter
from typing import Annotated, NamedTuple

import typer
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.experiment.load import Study, experiment_from
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.study_job import CHUNK, StudyJob, chunk_size
from passafe_services.tools.runs.sweep import sweep as run_sweep
from passafe_services.tools.runs.worker_processes import WorkerProcesses
from report import AsJson, Ratio, Report, Smallest, spread
from timing import in_turn

LINKS = ("plant-to-filter", "filter-to-plant")
WORKERS = (1, 2)


class Speed(NamedTuple):
    """Speed of one sweep: runs per second once all processes work, and how long it took until they did, s."""

    runs_per_s: float
    start_s: float


def main(
    runs: Annotated[int, typer.Option(min=20, help="Runs of each measurement.")] = 40,
    duration: Annotated[float, typer.Option(min=0.01, help="Plant time of each run, s.")] = 5.0,
    rounds: Annotated[int, typer.Option(min=1, help="Measurements with each number of workers, in turn.")] = 3,
    scenario: Annotated[str, typer.Option(help="Scenario, by name or file.")] = "notomista-cai-2020",
    rate: Annotated[float, typer.Option(min=1.0, max=1000.0, help="Ticks per second, Hz.")] = 1000.0,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time a sweep with delay, jitter and loss on both of the robot's links, random starts."""
    if smallest:
        runs, duration, rounds = 24, 0.05, 1
    study = sweep(scenario, runs, duration, rate)
    measured = in_turn([partial(speed, study, workers) for workers in WORKERS], rounds)
    report = Report(
        title=f"Sweep, {scenario}, {runs} runs of {duration:g} s at {rate:g} Hz, {rounds} rounds",
        columns=("workers", "runs/s", "× real time", "start", "1000 runs take"),
    )
    rates = [[each.runs_per_s for each in of] for of in measured]
    for workers, of, per_s in zip(WORKERS, measured, rates, strict=True):
        start_s, middle = median(each.start_s for each in of), median(per_s)
        ends = (f"{duration * middle:.0f}", f"{start_s:.1f} s", f"{start_s + 1000 / middle:.0f} s")
        report.rows.append((str(workers), spread(per_s, 2), *ends))
    report.ratios.append(Ratio.of_rounds("runs/s of two workers", rates[1], "one", rates[0]))
    report.finish(as_json=as_json)


def sweep(scenario: str, runs: int, duration_s: float, rate_hz: float) -> Study:
    """Return a study of so many runs, each over a bad network of its own."""
    links = {"delay_s": 0.1, "jitter_s": 0.01, "loss": 0.05}
    content = {
        "schema_version": 2,
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


def speed(study: Study, workers: int) -> Speed:
    """Return how fast a sweep is."""
    plan = Plan(study.experiment)
    begin_s = perf_counter()
    with closing(WorkerProcesses(StudyJob.of(study), workers)) as pool:
        chunks = run_sweep(plan, pool, partial(chunk_size, workers=workers))
        at_s = [perf_counter() - begin_s for chunk in chunks for _ in chunk]
    first = workers * CHUNK
    steady = range(2 * first, len(at_s))
    return Speed(linear_regression(at_s[2 * first :], steady).slope, at_s[first - 1])


if __name__ == "__main__":
    typer.run(main)
