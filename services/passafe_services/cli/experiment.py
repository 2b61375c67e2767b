"""``passafe experiment``: sweep a scenario in virtual time."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from passafe_services.cli.check import warn_at_load
from passafe_services.cli.errors import OptionError
from passafe_services.cli.experiment_live import live_beside_lockstep, show_agreement
from passafe_services.cli.options import WorkersOption, writable_folder
from passafe_services.cli.robot_option import OwnRobotOption
from passafe_services.cli.sweep import exit_if_interrupted, workers_for
from passafe_services.loop.stop import Stop, stop_requests
from passafe_services.tools.experiment.cells import Run, RunKey, cells_of
from passafe_services.tools.experiment.check import check
from passafe_services.tools.experiment.kept_list import KeptList
from passafe_services.tools.experiment.kept_logs import Keep, KeptLog, LogJob, chosen
from passafe_services.tools.experiment.load import Study, load_study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult, experiment_results
from passafe_services.tools.experiment.schema import MOST_RUNS
from passafe_services.tools.experiment.study_job import StudyJob, chunk_size
from passafe_services.tools.experiment.summary import ExperimentSummary
from passafe_services.tools.experiment.sweep_state import Stage, state_writer
from passafe_services.tools.runs.results_file import ResultsFile
from passafe_services.tools.runs.sweep import FixedPlan, sweep
from passafe_services.tools.runs.workers import Workers


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
    ] = 6,
    robot: OwnRobotOption = None,
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

    Nothing is done twice: a finished experiment started again shows its table and ends; more seeds or more logs add
    what is missing.

    Examples:
    - `passafe experiment delay --seeds 2 --out runs/delay`
    - `passafe experiment ./mine.toml --workers 8 --keep none --out runs/mine`
    """
    from passafe_services.cli.experiment_report import (  # noqa: PLC0415 - passafe[run] lacks its packages
        is_reported,
        show,
        show_kept,
        write_report,
    )

    study = _study(file, seeds, robot)
    folder = writable_folder(out)
    results_file = experiment_results(folder / "results.jsonl", study)
    plan = Plan(study.experiment, results_file.results)
    console = Console(highlight=False, soft_wrap=True)
    note = state_writer(folder, study.experiment.seeds)
    was_complete = plan.is_complete
    if not was_complete:
        check(study)
        warn_at_load(study.scenario_with({}))
        note("runs", plan.most_runs)
    with _noting_an_interruption(note, plan), stop_requests(lifeline=False) as stop:
        if not was_complete:
            with workers_for(StudyJob.of(study), workers, plan.most_runs, scheduler) as pool:
                _run(plan, results_file, pool, stop)
        exit_if_interrupted(stop, len(plan.results), folder, console)
        note("logs", len(plan.results))
        kept = _keep(chosen(plan, keep, keep_most), study, folder, workers, stop)
        exit_if_interrupted(stop, len(plan.results), folder, console)
    note("report", len(plan.results))
    agreement = live_beside_lockstep(plan, study, live, folder / "live", console) if live else []
    summary = ExperimentSummary.of(plan)
    if live or not is_reported(folder):
        write_report(plan, summary, kept, agreement, folder)
    elif was_complete:
        console.print(f"finished before: all {len(plan.results)} runs of {study.experiment.name} are in {folder}")
    note("finished", len(plan.results))
    show(summary, study.experiment, console)
    show_kept(kept, console)
    if agreement:
        show_agreement(agreement, console)
    console.print(f"page      {folder / 'report.html'}")
    broken = summary.errors or any(log.differing for log in kept) or not all(one.agrees for one in agreement)
    raise typer.Exit(1 if broken else 0)


@contextmanager
def _noting_an_interruption(note: Callable[[Stage, int], None], plan: Plan) -> Iterator[None]:
    """Write down that a sweep was interrupted if the block does not end."""
    try:
        yield
    except BaseException:
        note("interrupted", plan.most_runs)
        raise


def _study(file: str, seeds: int | None, robot: str | None) -> Study:
    study = load_study(file, robot)
    if seeds is None:
        return study
    cells = len(cells_of(study.experiment))
    if cells * seeds > MOST_RUNS:
        raise OptionError("--seeds", f"{cells * seeds} runs", f"up to {MOST_RUNS}, {MOST_RUNS // cells} of each cell")
    asked = study.experiment.seeds.model_copy(update={"count": seeds})
    return study.model_copy(update={"experiment": study.experiment.model_copy(update={"seeds": asked})})


def _run(plan: Plan, results: ResultsFile[RunKey, RunResult], workers: Workers[Run, RunResult], stop: Stop) -> None:
    """Run what the plan wants, write the results, and display the progress."""
    errors = sum(bool(result.error) for result in plan.results.values())
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[errors]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    chunks = sweep(plan, workers, partial(chunk_size, workers=workers.count), stop.is_requested)
    with Progress(*columns, console=Console(stderr=True), speed_estimate_period=60) as bar:
        known = len(plan.results)
        text = plan.experiment.name
        task = bar.add_task(text, total=plan.most_runs, completed=known, errors=_error_text(errors))
        for chunk in results.add(chunks):
            errors += sum(bool(result.error) for result in chunk)
            bar.update(task, advance=len(chunk), errors=_error_text(errors))
            if plan.experiment.bisected is not None:
                bar.update(task, total=plan.most_runs)


def _error_text(errors: int) -> str:
    return f"[red]{errors} errors[/]" if errors else ""


def _keep(wanted: list[RunResult], study: Study, folder: Path, workers: int, stop: Stop) -> list[KeptLog]:
    """Write the logs of the wanted runs that have none yet; return those of all in the order of ``wanted``."""
    if not wanted:
        return []
    job = LogJob.of(study, writable_folder(folder / "logs"))
    known = KeptList(folder)
    missing = [result for result in wanted if known.find(result) is None]
    if missing:
        _write_logs(missing, job, workers, stop, known)
    return [log for result in wanted if (log := known.find(result)) is not None]


def _write_logs(wanted: list[RunResult], job: LogJob, workers: int, stop: Stop, known: KeptList) -> None:
    """Write logs in processes of this machine, display the progress, and note each log that is whole."""
    with (
        Progress(*Progress.get_default_columns()[:3], console=Console(stderr=True), transient=True) as bar,
        workers_for(job, workers, len(wanted)) as pool,
    ):
        task = bar.add_task("logs", total=len(wanted))
        for logs in sweep(FixedPlan(wanted), pool, lambda _: 1, stop.is_requested):
            known.add(logs)
            bar.advance(task, len(logs))
