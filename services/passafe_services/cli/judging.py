"""Judges the log of a run for a command, with a bar of progress for a long one."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import Progress, TimeRemainingColumn

from passafe_services.log.log_pass import WORKERS_PAY_BYTES, LogConsumer, LogPass
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


def judged(path: Path, join: Join | None = None) -> Judged:
    """Return the verdict on a log, from one pass over it.

    Args:
        path: The log.
        join: Returns others that take part in the pass.
    """
    with ExitStack() as stack:
        run = LogPass(path)
        identity = identity_of(run)
        evaluator = CoreEvaluator(identity.scenario)
        review = RunReview(path, identity, evaluator)
        if run.size_bytes >= WORKERS_PAY_BYTES:
            columns = (*Progress.get_default_columns()[:3], TimeRemainingColumn())
            bar = stack.enter_context(Progress(*columns, console=Console(stderr=True), transient=True))
            task = bar.add_task("reviewing", total=run.size_bytes)
            run.progress = lambda read, _total: bar.update(task, completed=read)
        run.feed(review, *(() if join is None else join(identity, evaluator)))
    return Judged(Verdict.concluding(review, run), identity, evaluator)
