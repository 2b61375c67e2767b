"""Do the work of a job."""

from collections.abc import Callable

from passafe_services.tools.export.whole_file import whole_output

from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.jobs.job_order import JobOrder, JobReport
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import CompareRequest, ReviewRequest, SweepRequest, WhatIfRequest
from passafe_dashboard.jobs.review_work import compare, review
from passafe_dashboard.json_text import json_text


def do(order: JobOrder, report: Callable[[JobReport], object]) -> JobReport:
    """Do the work of an order, write its result and return the last report.

    Raises:
        PassafeError: It cannot be done.
        OSError: A file cannot be read or written.
    """
    folder, progress, log, text = RunsFolder(order.root), JobProgress(report), "", "done"
    request, result, verdict, experiment = order.request, None, "", ""
    if isinstance(request, ReviewRequest):
        result, verdict = review(request, folder, progress, processors=order.processors)
    elif isinstance(request, CompareRequest):
        result = compare(request, folder, progress)
    elif isinstance(request, WhatIfRequest):
        from passafe_dashboard.jobs.what_if_work import rerun  # noqa: PLC0415 - other jobs are quicker without

        result, log = rerun(request, folder, progress)
    elif isinstance(request, SweepRequest):
        from passafe_dashboard.jobs.sweep_work import sweep_experiment  # noqa: PLC0415 - likewise

        experiment, text = sweep_experiment(request, folder, progress, processors=order.processors)
    else:
        from passafe_dashboard.jobs.cell_run_work import repeat  # noqa: PLC0415 - likewise

        log, text = repeat(request, folder, progress)
    with whole_output(order.result) as unfinished:
        unfinished.write_text(json_text({} if result is None else result._asdict()), encoding="utf-8")
    return JobReport(event="done", share=1.0, text=text, log=log, verdict=verdict, experiment=experiment)
