"""Run the sweep of an experiment, for the page: its results are in its folder as they come."""

from collections.abc import Callable
from contextlib import closing
from itertools import count
from pathlib import Path
from typing import Final

from passafe_services.tools.check.scenario_check import load_warnings
from passafe_services.tools.experiment.check import check, tried_scenarios
from passafe_services.tools.experiment.kept_logs import KeptLog
from passafe_services.tools.experiment.load import Study, load_study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.schema import Seeds
from passafe_services.tools.experiment.study_sweep import StudySweep
from passafe_services.tools.experiment.summary import ExperimentSummary
from passafe_services.tools.experiment.sweep_state import SweepState
from passafe_services.tools.experiment.tables import write_summary
from passafe_services.tools.runs.results_file import ResultsHeading
from passafe_services.tools.runs.worker_processes import WorkerProcesses

from passafe_dashboard.archive.experiment_offers import MOST_RUNS
from passafe_dashboard.archive.runs_folder import RESULTS, RunsFolder
from passafe_dashboard.errors import SweepSizeError, SweptAlreadyError
from passafe_dashboard.experiment_report import write_experiment_report
from passafe_dashboard.jobs.job_order import JobReport
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import SweepRequest

MOST_TICKS: Final = 120_000
"""Ticks of one run: a worker keeps all of them in memory until it is judged."""

MOST_LOGS: Final = 6
"""Logs of worst runs that are kept, as the command keeps without an option."""


def sweep_experiment(
    request: SweepRequest, folder: RunsFolder, progress: JobProgress, *, processors: int
) -> tuple[str, str]:
    """Run an experiment to its end; return the name of its folder, and what has to be said of it.

    Args:
        request: The work.
        folder: The runs folder.
        progress: Where it is reported.
        processors: Processes that may run at a time; 0: one.

    Raises:
        PassafeError: It cannot be run, or not in the page.
    """
    study, place = _study(request, folder)
    _require_size(study)
    progress.part("checking that its runs can be built", 0.0, 0.02)
    check(study)
    load_warnings(study.scenario_with({}))
    place = place or _new_folder(folder.root, study.experiment.name)
    swept = StudySweep(study, place)
    swept.note("runs")
    progress.report(JobReport(event="progress", text="running", experiment=folder.name_of(place)))
    with swept.noting_an_interruption():
        if not swept.plan.is_complete:
            _run(swept, max(1, processors), progress.part("running", 0.02, 0.9))
        swept.note("logs")
        kept = _write_logs(swept, max(1, processors), progress.part("writing logs of the worst runs", 0.9, 0.97))
    swept.note("report")
    progress.part("writing its report", 0.97, 1.0)
    summary = ExperimentSummary.of(swept.plan)
    write_summary(swept.plan, summary, (), place)
    write_experiment_report(swept.plan, summary, kept, (), place)
    swept.note("finished")
    return folder.name_of(place), _outcome(swept, kept)


def _study(request: SweepRequest, folder: RunsFolder) -> tuple[Study, Path | None]:
    """Return the study that is asked for, and the folder of its results if there is one."""
    if request.source == "folder":
        place = folder.experiment(request.experiment)
        state = SweepState.read(place)
        if state is not None and state.runs_on:
            raise SweptAlreadyError(request.experiment, state.pid)
        study, seeds = _begun(place), None if state is None else state.seeds
    else:
        is_shipped, place, seeds = request.source == "shipped", None, None
        study = load_study(request.experiment if is_shipped else str(folder.experiment_file(request.experiment)))
    if request.seeds is not None:
        seeds = (seeds or study.experiment.seeds).model_copy(update={"count": request.seeds})
    return (study if seeds is None else _with_seeds(study, seeds)), place


def _begun(place: Path) -> Study:
    """Return the study that the results in a folder are of."""
    with (place / RESULTS).open("rb") as file:
        subject = ResultsHeading.model_validate_json(file.readline()).subject
    return Study.model_validate({name: subject[name] for name in ("experiment", "scenario")})


def _with_seeds(study: Study, seeds: Seeds) -> Study:
    return study.model_copy(update={"experiment": study.experiment.model_copy(update={"seeds": seeds})})


def _require_size(study: Study) -> None:
    runs = Plan(study.experiment).most_runs
    if runs > MOST_RUNS:
        raise SweepSizeError(study.experiment.name, f"{runs} runs", f"up to {MOST_RUNS}")
    ticks = max(scenario.duration_s * scenario.rate_hz for scenario in tried_scenarios(study))
    if ticks > MOST_TICKS:
        raise SweepSizeError(study.experiment.name, f"runs of {ticks:.0f} ticks", f"up to {MOST_TICKS}")


def _new_folder(root: Path, name: str) -> Path:
    """Make a folder under the experiment's name, with a number where there is one already."""
    root.mkdir(parents=True, exist_ok=True)
    for number in count(1):
        path = root / (name if number == 1 else f"{name}-{number}")
        try:
            path.mkdir()
        except FileExistsError:
            continue
        return path
    raise AssertionError("numbers end")


def _run(swept: StudySweep, processors: int, step: Callable[[int, int], None]) -> None:
    with closing(WorkerProcesses(swept.run_job(), min(processors, swept.plan.most_runs))) as workers:
        for _ in swept.run(workers, lambda: False):
            step(len(swept.plan.results), swept.plan.most_runs)


def _write_logs(swept: StudySweep, processors: int, step: Callable[[int, int], None]) -> list[KeptLog]:
    wanted = swept.worth_a_log("worst", MOST_LOGS)
    missing = swept.without_log(wanted)
    if missing:
        job, written = swept.log_job(), 0
        job.folder.mkdir(exist_ok=True)
        with closing(WorkerProcesses(job, min(processors, len(missing)))) as workers:
            for logs in swept.write_logs(missing, workers, lambda: False):
                written += len(logs)
                step(written, len(missing))
    return swept.logs_of(wanted)


def _outcome(swept: StudySweep, kept: list[KeptLog]) -> str:
    parts = []
    if swept.errors:
        parts.append(f"{swept.errors} runs could not be run: column error of runs.csv")
    parts += [f"{log.path.name} is another run: {', '.join(log.differing)} differ" for log in kept if log.differing]
    return "; ".join(parts) or "done"
