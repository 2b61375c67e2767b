"""Repeat a run of an experiment with a recorder, for the page."""

from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import CellRunRequest


def repeat(request: CellRunRequest, folder: RunsFolder, progress: JobProgress) -> str:
    """Repeat a run with a recorder; return the name of its log."""
    raise NotImplementedError
