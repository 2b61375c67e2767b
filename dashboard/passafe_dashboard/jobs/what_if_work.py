"""Run a log again with something changed, for the page."""

import json

from passafe_services.scenarios.load import scenario_from
from passafe_services.tools.compare.comparison import Comparison
from passafe_services.tools.compare.run_metrics import ReviewedRun
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.notes import notes_of
from passafe_services.tools.what_if.rerun import Conditions
from passafe_services.tools.what_if.what_if import Question

from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import WhatIfRequest
from passafe_dashboard.jobs.review_work import compared, log_for_memory
from passafe_dashboard.jobs.unfinished_log import put_beside, unfinished_folder
from passafe_dashboard.reports.run_page import ReportParts

OWN_SOURCE = "the scenario's own source"


def rerun(request: WhatIfRequest, folder: RunsFolder, progress: JobProgress) -> tuple[ReportParts, str]:
    """Run a log again; return both runs over one another, and the name of the new log.

    Raises:
        PassafeError: The log cannot be run again, or not with this change.
    """
    progress.part("reading the log", 0.05, 0.2)
    path = log_for_memory(folder, request.log, "passafe whatif")
    question = Question.of(RunLog.read(path))
    logged = question.log.identity.scenario
    scenario = scenario_from(json.loads(logged.model_dump_json()), logged.name, request.changes)
    acts = request.operator == "scenario"
    conditions = Conditions(scenario=scenario, operator_acts=acts, links=request.links)
    with unfinished_folder(path.parent, progress.report) as unfinished:
        made = unfinished / path.name
        step = progress.part("running again", 0.2, 0.7)
        result = question.answer(conditions, made, operator=OWN_SOURCE if acts else "", progress=step)
        out = put_beside(made, path, "what-if")
    progress.part("comparing", 0.72, 0.9)
    reviewed = [ReviewedRun.of(question.log), ReviewedRun.of(RunLog.read(out))]
    notes = [f"{what}: {words}" for what, words in notes_of(result)]
    title = f"{logged.title}: what if"
    parts = compared(reviewed, Comparison.of(reviewed), ["log", "what if"], title=title, notes=notes)
    return parts, folder.name_of(out)
