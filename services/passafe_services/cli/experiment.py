"""``passafe experiment``: sweep a scenario in virtual time."""

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
from passafe_services.tools.experiment.cells import Run, cells_of
from passafe_services.tools.experiment.check import check
from passafe_services.tools.experiment.kept_logs import Keep, KeptLog
from passafe_services.tools.experiment.load import Study, load_study
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.schema import MOST_RUNS
from passafe_services.tools.experiment.study_sweep import StudySweep
from passafe_services.tools.experiment.summary import ExperimentSummary
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
    swept = StudySweep(study, folder)
    plan = swept.plan
    console = Console(highlight=False, soft_wrap=True)
    was_complete = plan.is_complete
    if not was_complete:
        check(study)
        warn_at_load(study.scenario_with({}))
        swept.note("runs")
    with swept.noting_an_interruption(), stop_requests(lifeline=False) as stop:
        if not was_complete:
            with workers_for(swept.run_job(), workers, plan.most_runs, scheduler) as pool:
                _run(swept, pool, stop)
        exit_if_interrupted(stop, len(plan.results), folder, console)
        swept.note("logs")
        kept = _keep(swept, swept.worth_a_log(keep, keep_most), workers, stop)
        exit_if_interrupted(stop, len(plan.results), folder, console)
    swept.note("report")
    agreement = live_beside_lockstep(plan, study, live, folder / "live", console) if live else []
    summary = ExperimentSummary.of(plan)
    if live or not is_reported(folder):
        write_report(plan, summary, kept, agreement, folder)
    elif was_complete:
        console.print(f"finished before: all {len(plan.results)} runs of {study.experiment.name} are in {folder}")
    swept.note("finished")
    show(summary, study.experiment, console)
    show_kept(kept, console)
    if agreement:
        show_agreement(agreement, console)
    console.print(f"page      {folder / 'report.html'}")
    broken = summary.errors or any(log.differing for log in kept) or not all(one.agrees for one in agreement)
    raise typer.Exit(1 if broken else 0)


def _study(file: str, seeds: int | None, robot: str | None) -> Study:
    study = load_study(file, robot)
    if seeds is None:
        return study
    cells = len(cells_of(study.experiment))
    if cells * seeds > MOST_RUNS:
        raise OptionError("--seeds", f"{cells * seeds} runs", f"up to {MOST_RUNS}, {MOST_RUNS // cells} of each cell")
    asked = study.experiment.seeds.model_copy(update={"count": seeds})
    return study.model_copy(update={"experiment": study.experiment.model_copy(update={"seeds": asked})})


def _run(swept: StudySweep, workers: Workers[Run, RunResult], stop: Stop) -> None:
    """Run what the sweep wants, and display the progress."""
    plan, errors = swept.plan, swept.errors
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
        text = plan.experiment.name
        task = bar.add_task(text, total=plan.most_runs, completed=known, errors=_error_text(errors))
        for chunk in swept.run(workers, stop.is_requested):
            errors += sum(bool(result.error) for result in chunk)
            bar.update(task, advance=len(chunk), errors=_error_text(errors))
            if plan.experiment.bisected is not None:
                bar.update(task, total=plan.most_runs)


def _error_text(errors: int) -> str:
    return f"[red]{errors} errors[/]" if errors else ""


def _keep(swept: StudySweep, wanted: list[RunResult], workers: int, stop: Stop) -> list[KeptLog]:
    """Write the logs of the wanted runs that have none yet, display the progress, and return those of all."""
    missing = swept.without_log(wanted)
    if missing:
        writable_folder(swept.log_job().folder)
        with (
            Progress(*Progress.get_default_columns()[:3], console=Console(stderr=True), transient=True) as bar,
            workers_for(swept.log_job(), workers, len(missing)) as pool,
        ):
            task = bar.add_task("logs", total=len(missing))
            for logs in swept.write_logs(missing, pool, stop.is_requested):
                bar.advance(task, len(logs))
    return swept.logs_of(wanted)
