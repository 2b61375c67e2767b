"""Errors of the operator process; the tree of all errors is in ``passafe.errors``."""

from pathlib import Path
from typing import ClassVar

from passafe.errors import NotAllowedError


class SourceConfigError(NotAllowedError):
    """A setting of a source of commands that does not fit the robot, or its range."""

    prefix = "operator.source."
    quotes_got: ClassVar[bool] = True


class RecordingError(NotAllowedError):
    """A place in a CSV file that is no part of a command series.

    Attributes:
        path: The file.
        line: Line in it, from 1; 0 where the file as a whole is meant.
        column: Name of the column; empty where the line as a whole is meant.
    """

    quotes_got: ClassVar[bool] = True

    def __init__(self, path: Path, *, line: int, column: str, got: object, allowed: str) -> None:
        self.path = path
        self.line = line
        self.column = column
        place = f"{path}:{line}" if line else str(path)
        super().__init__(f"{place}: column {column}" if column else place, got, allowed)


class TerminalError(NotAllowedError):
    """A keyboard was asked for where no person could drive from a terminal."""

    def __init__(self, got: str, allowed: str) -> None:
        super().__init__("keyboard", got, allowed)
