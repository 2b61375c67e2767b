"""Write a log where nobody takes it for a whole one, until it is."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from tempfile import mkdtemp

from passafe_dashboard.jobs.job_order import JobReport


@contextmanager
def unfinished_folder(parent: Path, report: Callable[[JobReport], object]) -> Iterator[Path]:
    """Yield a new hidden folder on the same disk, which is gone at the end of the block.

    Args:
        parent: Folder to make it in.
        report: Is given its path, so that the server removes it if this process is killed.
    """
    folder = Path(mkdtemp(prefix=".unfinished-", dir=parent))
    report(JobReport(event="progress", unfinished=folder))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def put_beside(log: Path, original: Path, ending: str) -> Path:
    """Move a log beside another one, under its name with an ending and a number that nothing has yet.

    Args:
        log: The log to move.
        original: The log that it belongs to.
        ending: Words behind the name.

    Returns:
        Its new path.
    """
    for number in count(1):
        path = original.with_name(f"{original.stem}-{ending}-{number}{original.suffix}")
        try:
            path.touch(exist_ok=False)
        except FileExistsError:
            continue
        return log.replace(path)
    raise AssertionError("numbers end")
