"""Logs of the runs that are worth a look: each is repeated with a recorder, and checked to be the same run."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal, NamedTuple, Self

from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.tools.experiment.cells import RunKey
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.experiment.summary import badness_of, in_order, worst_result
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

Keep = Literal["worst", "failed", "none"]

REVIEWED = (
    "h_min",
    "h_min_barrier",
    "h_min_at_samples",
    "tank_min_j",
    "power_margin_min",
    "power_margin_min_at_samples",
    "u_norm_max",
    "sequence_breaks",
    "status_counts",
    "command_age_ms_p50",
    "command_age_ms_p99",
    "final_x",
    "steering",
    "duration_s",
    "ticks",
    "verdict",
)
"""Metrics that both a review and a sweep have: of the same run they are the same to the last bit."""


class KeptLog(NamedTuple):
    """The log of a run.

    Attributes:
        result: The sweep's result.
        path: The file.
        differing: Metrics of which review and sweep disagree; empty, or something is broken.
    """

    result: RunResult
    path: Path
    differing: tuple[str, ...]


def chosen(plan: Plan, keep: Keep, most: int) -> list[RunResult]:
    """Return the runs to keep, the worst first, no more than ``most``.

    Args:
        plan: With its results.
        keep: ``worst``: of each cell the worst; ``failed``: all that break a criterion.
        most: How many.
    """
    ran = [result for result in sorted(plan.results.values(), key=in_order) if result.metrics is not None]
    found: list[RunResult] = []
    if keep == "failed":
        criteria = plan.experiment.criteria.values()
        found = [one for one in ran if not all(criterion.holds(one.metrics) for criterion in criteria)]
    elif keep == "worst":
        cells: dict[int, list[RunResult]] = {}
        for one in ran:
            cells.setdefault(one.run.cell, []).append(one)
        found = [worst_result(runs, plan.experiment.worst) for runs in cells.values()]
    return sorted(found, key=partial(badness_of, criterion=plan.experiment.worst), reverse=True)[:most]


@dataclass(frozen=True, kw_only=True, slots=True)
class LogJob:
    """The logs of one study, as workers see them; a task is the result of a run whose log is to be written.

    Attributes:
        study_json: The study.
        folder: Where the logs go.
    """

    study_json: str
    folder: Path

    @classmethod
    def of(cls, study: Study, folder: Path) -> Self:
        """Return the job of a study's logs."""
        return cls(study_json=study.model_dump_json(), folder=folder)

    def compile(self) -> Callable[[Sequence[RunResult]], list[KeptLog]]:
        """Return the function from results to the logs that it writes of their runs."""
        runner = StudyRunner(Study.model_validate_json(self.study_json))
        return lambda results: [write_log(runner, result, self.folder) for result in results]


def log_name_of(key: RunKey) -> str:
    """Return the name of the log of a run."""
    at = "" if key.probe is None else f"-at-{key.probe:.6g}"
    return f"cell-{key.cell}{at}-seed-{key.seed}.mcap"


def write_log(runner: StudyRunner, result: RunResult, folder: Path) -> KeptLog:
    """Repeat a run with a recorder, and compare the metrics of its log with those of the sweep.

    The log has its name when it is whole: a worker that is killed leaves none that looks like one.
    """
    scenario = runner.scenario_of(result.run)
    path = folder / log_name_of(result.run.key)
    unfinished = path.with_name(f".unfinished-{path.name}")
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(unfinished, metadata) as log:
        runner.trace(scenario, LockstepLog(log))
    verdict = Verdict.of(RunLog.read(unfinished), CoreEvaluator(scenario))
    differing = tuple(name for name in REVIEWED if getattr(result.metrics, name) != getattr(verdict, name))
    return KeptLog(result, unfinished.replace(path), differing)
