"""Make the HTML report of a log, in a pass over it, or of two logs over one another."""

from collections.abc import Sequence
from pathlib import Path

from passafe_services.log.log_pass import LogPass
from passafe_services.tools.compare.run_metrics import ReviewedRun
from passafe_services.tools.export.whole_file import whole_output
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_identity import RunIdentity
from passafe_services.tools.review.verdict import Verdict

from passafe_dashboard.reports.report_run import ReportRun
from passafe_dashboard.reports.run_page import report_page
from passafe_dashboard.run_record.collector import RunCollector

__all__ = [
    "ReportRun",
    "RunCollector",
    "overlay_report",
    "render_report",
    "report_run",
    "report_runs",
    "write_report",
]


def render_report(record: RunCollector, verdict: Verdict, identity: RunIdentity) -> str:
    """Return the report of a run as one self-contained HTML file.

    Args:
        record: Its record, after a pass over its log.
        verdict: Result of the review.
        identity: Identity of the run.
    """
    return report_page([report_run(record, verdict, identity)], title=identity.scenario.title)


def overlay_report(runs: Sequence[ReportRun], *, title: str, notes: Sequence[str] = ()) -> str:
    """Return the report of several runs over one another as one self-contained HTML file.

    Args:
        runs: The runs, see ``report_run``; scene and choice of charts are those of the first.
        title: Heading.
        notes: Sentences under the verdicts.
    """
    return report_page(runs, title=title, notes=notes)


def report_run(
    record: RunCollector, verdict: Verdict, identity: RunIdentity, *, label: str = "run", offset_s: float = 0.0
) -> ReportRun:
    """Return one run of a report.

    Args:
        record: Its record, after a pass over its log.
        verdict: Result of the review.
        identity: Identity of the run.
        label: What a report of several runs calls it.
        offset_s: Seconds to add to its plant time, so that it lies over another run.
    """
    return ReportRun(
        label=label,
        record=record,
        verdict=verdict.model_dump(mode="json"),
        configuration=identity.scenario.model_dump(mode="json"),
        versions=identity.versions,
        offset_s=offset_s,
    )


def report_runs(runs: Sequence[ReviewedRun], names: Sequence[str], origins_s: Sequence[float]) -> list[ReportRun]:
    """Return reviewed runs as those of one report, from another pass over each log.

    Args:
        runs: The runs.
        names: What the report calls them.
        origins_s: Plant time of each that counts as zero, s.
    """
    shown = []
    for run, name, origin_s in zip(runs, names, origins_s, strict=True):
        identity = run.log.identity
        record = RunCollector(identity.scenario, CoreEvaluator(identity.scenario))
        LogPass(run.log.path).feed(record)
        shown.append(report_run(record, run.verdict, identity, label=name, offset_s=-origin_s))
    return shown


def write_report(path: Path, html: str) -> None:
    """Write a report; what stands at the path stays until the new one is whole.

    Raises:
        ExportError: It cannot be written.
    """
    with whole_output(path) as unfinished:
        unfinished.write_text(html, encoding="utf-8")
