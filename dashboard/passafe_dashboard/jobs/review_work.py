"""Review a log, or compare two, for the page."""

from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Final

from passafe_services.log.log_files import files_of
from passafe_services.tools.compare.comparison import Comparison
from passafe_services.tools.compare.run_metrics import ReviewedRun
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.log_judging import judge_log
from passafe_services.tools.review.run_identity import RunIdentity
from passafe_services.tools.review.run_log import RunLog

from passafe_dashboard.archive.runs_folder import LOG_SUFFIX, RunsFolder
from passafe_dashboard.errors import TooLargeLogError
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import CompareRequest, ReviewRequest
from passafe_dashboard.reports.run_page import ReportParts, report_parts
from passafe_dashboard.run_record.collector import RunCollector
from passafe_dashboard.run_report import report_run, report_runs

MOST_BYTES_IN_MEMORY: Final = 48 << 20
"""Largest log of which all messages are kept in memory."""


def review(
    request: ReviewRequest, folder: RunsFolder, progress: JobProgress, *, processors: int
) -> tuple[ReportParts, str]:
    """Return the report of a log and its verdict in a few words, from one pass over it."""
    records: list[RunCollector] = []

    def join(identity: RunIdentity, evaluator: CoreEvaluator) -> Sequence[RunCollector]:
        records.append(RunCollector(identity.scenario, evaluator))
        return records

    path = folder.log(request.log)
    step = progress.part("reading the log", 0.05, 0.9)
    found = judge_log(path, join, progress=step, workers=processors or 0)
    progress.part("drawing", 0.92, 1.0)
    run = report_run(records[0], found.verdict, found.identity)
    violated = run.not_required()
    verdict = found.verdict.verdict + (f"; violated, not required: {', '.join(violated)}" if violated else "")
    return report_parts([run], title=found.identity.scenario.title), verdict


def compare(request: CompareRequest, folder: RunsFolder, progress: JobProgress) -> ReportParts:
    """Return the report of two logs over one another."""
    reviewed = []
    for number, name in enumerate(request.logs):
        progress.part(f"reading {name}", 0.05 + 0.4 * number, 0.45 + 0.4 * number)
        reviewed.append(ReviewedRun.of(RunLog.read(log_for_memory(folder, name, "passafe compare"))))
    progress.part("drawing", 0.87, 1.0)
    comparison = Comparison.of(reviewed, request.align)
    return compared(reviewed, comparison, labels_of(request.logs), title=" and ".join(request.logs))


def compared(
    reviewed: Sequence[ReviewedRun],
    comparison: Comparison,
    labels: Sequence[str],
    *,
    title: str,
    notes: Sequence[str] = (),
) -> ReportParts:
    """Return the report of a comparison."""
    runs = report_runs(reviewed, labels, [run.origin_s for run in comparison.runs])
    return report_parts(runs, title=title, notes=notes, comparison=comparison)


def log_for_memory(folder: RunsFolder, name: str, command: str) -> Path:
    """Return the path of a log that is small enough to be kept in memory.

    Args:
        folder: The runs folder.
        name: Its name there.
        command: Command that does the same without a limit.

    Raises:
        ArchiveNameError: There is no such log.
        TooLargeLogError: It is too large.
    """
    path = folder.log(name)
    size_bytes = sum(each.stat().st_size for each in files_of(path))
    if size_bytes > MOST_BYTES_IN_MEMORY:
        raise TooLargeLogError(name, size_bytes, MOST_BYTES_IN_MEMORY, command)
    return path


def labels_of(names: Sequence[str]) -> list[str]:
    """Return short names of logs: without folders where they differ without."""
    stems = [PurePosixPath(name).name.removesuffix(LOG_SUFFIX) for name in names]
    if len(set(stems)) == len(stems):
        return stems
    whole = [name.removesuffix(LOG_SUFFIX) for name in names]
    return whole if len(set(whole)) == len(whole) else [f"{name} ({k})" for k, name in enumerate(whole, start=1)]
