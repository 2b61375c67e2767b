"""Repeat a run of an experiment with a recorder, for the page."""

import json
from pathlib import Path

from passafe_services.tools.experiment.cells import RunKey
from passafe_services.tools.experiment.kept_logs import write_log
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.runs.results_file import ResultsHeading

from passafe_dashboard.archive.runs_folder import RESULTS, RunsFolder
from passafe_dashboard.errors import ArchiveNameError
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import CellRunRequest
from passafe_dashboard.jobs.unfinished_log import unfinished_folder


def repeat(request: CellRunRequest, folder: RunsFolder, progress: JobProgress) -> tuple[str, str]:
    """Repeat a run with a recorder; return the name of its log, and what has to be said of it.

    Raises:
        ArchiveNameError: The experiment has no such run.
    """
    place = folder.experiment(request.experiment)
    key = RunKey(request.cell, request.probe, request.seed)
    study, result = _found(place / RESULTS, key)
    if result is None or result.metrics is None:
        named = f"cell {key.cell}, seed {key.seed}"
        raise ArchiveNameError("run", named, f"a run of {request.experiment} that could be run")
    logs = place / "logs"
    logs.mkdir(exist_ok=True)
    progress.part("running it again", 0.3, 0.9)
    with unfinished_folder(logs, progress.report) as unfinished:
        kept = write_log(StudyRunner(study), result, unfinished)
        path = kept.path.replace(logs / kept.path.name)
    text = f"it is another run than that of the sweep: {', '.join(kept.differing)} differ" if kept.differing else "done"
    return folder.name_of(path), text


def _found(path: Path, key: RunKey) -> tuple[Study, RunResult | None]:
    """Return the study that results are of, and the result of one run."""
    with path.open("rb") as file:
        subject = ResultsHeading.model_validate_json(file.readline()).subject
        study = Study.model_validate({name: subject[name] for name in ("experiment", "scenario")})
        marks = f'"cell":{key.cell},'.encode(), f'"seed":{key.seed}'.encode()
        for line in file:
            if all(mark in line for mark in marks) and line.endswith(b"\n"):
                result = RunResult.model_validate(json.loads(line))
                if result.run.key == key:
                    return study, result
    return study, None
