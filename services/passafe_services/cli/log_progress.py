"""Shows how far a pass over a long log has come, and how long it will take."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from rich.console import Console
from rich.progress import Progress as Bar
from rich.progress import TimeRemainingColumn

from passafe_services.log.log_pass import WORKERS_PAY_BYTES, Progress


@contextmanager
def log_progress(doing: str) -> Iterator[Progress]:
    """Yield what takes the bytes read so far; a bar appears where there are many.

    Args:
        doing: Word before the bar, for example ``reviewing``.
    """
    columns = (*Bar.get_default_columns()[:3], TimeRemainingColumn())
    bar = Bar(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(doing, total=None)
    with ExitStack() as stack:

        def show(read: int, size_bytes: int) -> None:
            if size_bytes >= WORKERS_PAY_BYTES:
                if not bar.live.is_started:
                    stack.enter_context(bar)
                bar.update(task, completed=read, total=size_bytes)

        yield show
