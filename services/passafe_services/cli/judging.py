"""Judges the log of a run for a command, with a bar of progress for a long one."""

from pathlib import Path

from passafe_services.cli.log_progress import log_progress
from passafe_services.tools.review.log_judging import Join, Judged, judge_log


def judged(path: Path, join: Join | None = None) -> Judged:
    """Return the verdict on a log, from one pass over it.

    Args:
        path: The log.
        join: Returns others that take part in the pass.
    """
    with log_progress("reviewing") as show:
        return judge_log(path, join, progress=show)
