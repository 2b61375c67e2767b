"""Logs of the runs that are worth looking at: run again with a recorder, and checked to be the same run."""

from functools import partial
from pathlib import Path
from typing import Literal, NamedTuple

from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.experiment.runs import Result
from passafe_services.tools.experiment.summary import goodness, in_order, worst_of
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
"""Figures that both a review and a sweep have: of the same run they are the same to the last bit."""


class KeptLog(NamedTuple):
    """The log of a run.

    Attributes:
        result: What the sweep says of it.
        path: The file.
        differing: Figures that the log does not give as the sweep does; empty, or something is broken.
    """

    result: Result
    path: Path
    differing: tuple[str, ...]


def chosen(plan: Plan, keep: Keep, most: int) -> list[Result]:
    """Return the runs to keep, the worst first, no more than ``most``.

    Args:
        plan: With its results.
        keep: ``worst``: of each cell the worst; ``failed``: all that break a criterion.
        most: How many.
    """
    ran = [result for result in sorted(plan.results.values(), key=in_order) if result.figures is not None]
    found: list[Result] = []
    if keep == "failed":
        criteria = plan.experiment.criteria.values()
        found = [one for one in ran if not all(criterion.holds(one.figures) for criterion in criteria)]
    elif keep == "worst":
        cells: dict[int, list[Result]] = {}
        for one in ran:
            cells.setdefault(one.run.cell, []).append(one)
        found = [worst_of(runs, plan.experiment.worst) for runs in cells.values()]
    return sorted(found, key=partial(goodness, criterion=plan.experiment.worst))[:most]


def write_log(study: Study, result: Result, folder: Path) -> KeptLog:
    """Run a run again with a recorder, and compare what its log shows with what the sweep says."""
    run = result.run
    bench = StudyRunner(study)
    scenario = bench.scenario_of(run)
    at = "" if run.probe is None else f"-at-{run.probe:.6g}"
    path = folder / f"cell-{run.cell}{at}-seed-{run.seed}.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as log:
        bench.play(scenario, LockstepLog(log))
    return KeptLog(result, path, _differing(result, Verdict.of(RunLog.read(path), CoreEvaluator(scenario))))


def _differing(result: Result, verdict: Verdict) -> tuple[str, ...]:
    return tuple(name for name in REVIEWED if getattr(result.figures, name) != getattr(verdict, name))
