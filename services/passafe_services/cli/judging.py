"""Judges the log of a run for a command, with a bar of progress for a long one."""

from contextlib import ExitStack
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, TimeRemainingColumn

from passafe_services.log.log_pass import WORKERS_PAY_BYTES
from passafe_services.tools.review.log_judging import Join, Judged, judge_log


def judged(path: Path, join: Join | None = None) -> Judged:
    """Return the verdict on a log, from one pass over it.

    Args:
        path: The log.
        join: Returns others that take part in the pass.
    """
    columns = (*Progress.get_default_columns()[:3], TimeRemainingColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task("reviewing", total=None)
    with ExitStack() as stack:

        def show(read: int, size_bytes: int) -> None:
            if size_bytes >= WORKERS_PAY_BYTES:
                if not bar.live.is_started:
                    stack.enter_context(bar)
                bar.update(task, completed=read, total=size_bytes)

        return judge_log(path, join, progress=show)
