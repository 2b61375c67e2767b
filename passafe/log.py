"""Read the log of a run into tables: ``run = passafe.log.read("run.mcap")``, then ``run.ticks["tank_j"]``.

The core knows no files: this module loads what reads them when it is called (decision 0023).
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from passafe.errors import MissingPackageError

if TYPE_CHECKING:
    from os import PathLike

    from passafe_services.tables.run_tables import RunTables

__all__ = ["read"]


def read(path: "str | PathLike[str]", *, topics: Iterable[str] | None = None) -> "RunTables":
    """Return the messages of a log as tables of NumPy arrays, one for each topic; of a torn log, what can be read.

    Args:
        path: An MCAP log of passafe.
        topics: Names of the topics to read, such as ``("tick", "state")``; all if not given.

    Returns:
        ``run.ticks``, ``run.states``, ``run.commands``, ``run.inputs``, …: ``run.states["x_1"]`` is a NumPy array,
        ``run.states.matrix("x")`` all of x, shape (rows, n), and ``run.states.pandas()`` a data frame.

    Raises:
        LogReadError: The file is missing, empty, no MCAP file or no log of passafe.
        TopicNameError: There is no such topic.
        MissingPackageError: Only the core is installed.
    """
    try:
        from passafe_services.tables.run_tables import RunTables  # noqa: PLC0415 - the core alone does without
    except ModuleNotFoundError as error:
        raise MissingPackageError.of(error, "run") from error
    return RunTables.read(path, topics=topics)
