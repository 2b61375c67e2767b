"""Judge the log of a run in one pass, in which others may take part."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from passafe_services.log.log_pass import LogConsumer, LogPass, Progress
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_identity import RunIdentity
from passafe_services.tools.review.run_review import RunReview, identity_of
from passafe_services.tools.review.verdict import Verdict

Join = Callable[[RunIdentity, CoreEvaluator], Sequence[LogConsumer]]
"""Makes consumers of a pass, of what the log says of its run."""


class Judged(NamedTuple):
    """Verdict on a log, with what it rests on.

    Attributes:
        verdict: The verdict.
        identity: Scenario, driver and versions of the run.
        evaluator: Functions of the scenario.
    """

    verdict: Verdict
    identity: RunIdentity
    evaluator: CoreEvaluator


def judge_log(
    path: Path, join: Join | None = None, *, progress: Progress | None = None, workers: int | None = None
) -> Judged:
    """Return the verdict on a log, from one pass over it.

    Args:
        path: The log.
        join: Returns others that take part in the pass.
        progress: As of ``LogPass``.
        workers: As of ``LogPass``.

    Raises:
        LogFileError: The log cannot be read or reviewed.
    """
    run = LogPass(path, progress=progress, workers=workers)
    identity = identity_of(run)
    evaluator = CoreEvaluator(identity.scenario)
    review = RunReview(path, identity, evaluator)
    run.feed(review, *(() if join is None else join(identity, evaluator)))
    return Judged(Verdict.concluding(review, run), identity, evaluator)
