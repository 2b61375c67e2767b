"""``passafe experiment``: sweep a scenario in virtual time."""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Final

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from passafe_services.cli.experiment_live import live_beside_lockstep, show_agreement
from passafe_services.cli.experiment_report import show, show_kept, write_report
from passafe_services.cli.options import WorkersOption, writable_folder
from passafe_services.loop.realtime import available_processors
from passafe_services.loop.stop import Stop, stop_requests
from passafe_services.tools.experiment.check import check
from passafe_services.tools.experiment.kept_logs import Keep, KeptLog, chosen, write_log
from passafe_services.tools.experiment.load import Study, load_study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.results_file import ResultsFile
from passafe_services.tools.experiment.runs import Result
from passafe_services.tools.experiment.summary import ExperimentSummary
from passafe_services.tools.experiment.worker_pool import WorkerPool, dask_cluster, local_processes, results

INTERRUPTED: Final = 130
"""Exit code after Ctrl-C, as shells have it."""


def experiment(
    file: Annotated[
        str,
        typer.Argument(metavar="NAME|FILE", help="Shipped experiment (delay, gain, …) or TOML file."),
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder for results, tables, report and logs.")
    ],
    workers: WorkersOption = 0,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Run on a Dask cluster instead, e.g. tcp://10.0.0.1:8786."),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option("--seeds", "-n", metavar="N", min=1, help="Runs of each cell, instead of the file's number."),
    ] = None,
    keep: Annotated[Keep, typer.Option("--keep", help="Runs of which a log is written.")] = "worst",
    keep_most: Annotated[
        int, typer.Option("--keep-most", metavar="N", min=0, help="Largest number of logs; the worst runs come first.")
    ] = 20,
    live: Annotated[
        int, typer.Option("--live", metavar="N", min=0, help="Cells to run as real processes too, for comparison.")
    ] = 0,
) -> None:
    """Run a scenario under many conditions in virtual time, and report where its criteria hold.

    The file names a scenario, the values to vary (listed, drawn at random, or bisected until a criterion fails),
    named variants, seeds and criteria. Every run is that of `passafe simulate` without a log, judged as by
    `passafe review`. Results are written as they come, and the same command resumes after an interruption. Writes
    runs, cells and boundaries as CSV and Parquet, an HTML report, and logs of the worst runs. Exits with 0 if every
    run could be run, whatever it showed, and live runs agree with lockstep.

    Examples:
    - `passafe experiment delay --seeds 2 --out runs/delay`
    - `passafe experiment ./mine.toml --workers 8 --keep none --out runs/mine`
    """
    study = _study(file, seeds)
    check(study)
    folder = writable_folder(out)
    records = ResultsFile(folder / "results.jsonl", study)
    plan = Plan(study.experiment, records.results)
    console = Console(highlight=False, soft_wrap=True)
    with stop_requests(lifeline=False) as stop:
        with _crew(workers, scheduler) as crew:
            _sweep(plan, study, records, crew, stop)
        if stop.reason is not None:
            console.print(f"interrupted after {len(plan.results)} runs; the same command resumes in {folder}")
            raise typer.Exit(INTERRUPTED)
        kept = _kept(plan, study, keep, keep_most, folder, workers)
    agreement = live_beside_lockstep(plan, study, live, folder / "live", console) if live else []
    summary = ExperimentSummary.of(plan)
    write_report(plan, summary, kept, agreement, folder)
    show(summary, study.experiment, console)
    show_kept(kept, console)
    if agreement:
        show_agreement(agreement, console)
    console.print(f"page      {folder / 'report.html'}")
    broken = summary.errors or any(log.differing for log in kept) or not all(one.agrees for one in agreement)
    raise typer.Exit(1 if broken else 0)


def _study(file: str, seeds: int | None) -> Study:
    study = load_study(file)
    if seeds is None:
        return study
    asked = study.experiment.seeds.model_copy(update={"count": seeds})
    return study.model_copy(update={"experiment": study.experiment.model_copy(update={"seeds": asked})})


@contextmanager
def _crew(workers: int, scheduler: str | None) -> Iterator[WorkerPool]:
    chosen_crew = local_processes(_processes(workers)) if scheduler is None else dask_cluster(scheduler)
    with chosen_crew as crew:
        yield crew


def _processes(workers: int) -> int:
    return workers or available_processors()


def _sweep(plan: Plan, study: Study, records: ResultsFile, crew: WorkerPool, stop: Stop) -> None:
    """Run what is wanted, write it down, and show how far it is."""
    errors = sum(bool(result.error) for result in plan.results.values())
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[errors]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), speed_estimate_period=60) as bar:
        known = len(plan.results)
        task = bar.add_task(study.experiment.name, total=plan.most_runs, completed=known, errors=_told(errors))
        for result in records.add(results(plan, study, crew, lambda: stop.reason is not None)):
            errors += bool(result.error)
            bar.update(task, advance=1, errors=_told(errors))
            if plan.experiment.bisected is not None:
                bar.update(task, total=plan.most_runs)


def _told(errors: int) -> str:
    return f"[red]{errors} errors[/]" if errors else ""


def _kept(plan: Plan, study: Study, keep: Keep, most: int, folder: Path, workers: int) -> list[KeptLog]:
    """Write the logs that are to be kept, in processes of this machine."""
    wanted = chosen(plan, keep, most)
    if not wanted:
        return []
    logs = writable_folder(folder / "logs")
    kept: list[KeptLog] = []
    with Progress(*Progress.get_default_columns()[:3], console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("logs", total=len(wanted))
        with ProcessPoolExecutor(min(_processes(workers), len(wanted)), get_context("spawn")) as pool:
            for log in pool.map(partial(_log_of, study, logs), wanted):
                kept.append(log)
                bar.advance(task)
    return kept


def _log_of(study: Study, folder: Path, result: Result) -> KeptLog:
    return write_log(study, result, folder)
