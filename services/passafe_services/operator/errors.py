"""Errors of the operator process.

* ``OperatorError``
    * ``SourceConfigError``: a source's setting that does not fit the robot or its range
    * ``RecordingError``: a recorded command series that cannot be read as one
    * ``TerminalError``: a keyboard was asked for where there is no usable terminal
"""

from pathlib import Path


class OperatorError(Exception):
    """Anything that keeps an operator from starting."""


class SourceConfigError(OperatorError):
    """A source's setting that does not fit.

    Attributes:
        field: Name of the setting, as in the scenario file.
        got: Its value.
        allowed: What is allowed, in words.
    """

    def __init__(self, field: str, got: object, allowed: str) -> None:
        self.field = field
        self.got = got
        self.allowed = allowed
        super().__init__(f"operator.source.{field}: got {got!r}, allowed {allowed}")


class RecordingError(OperatorError):
    """A place in a CSV file that is no part of a command series.

    Attributes:
        path: The file.
        line: Line in it, from 1; 0 where the file as a whole is meant.
        column: Name of the column; empty where the line as a whole is meant.
        got: What stands there.
        allowed: What is allowed, in words.
    """

    def __init__(self, path: Path, *, line: int, column: str, got: object, allowed: str) -> None:
        self.path = path
        self.line = line
        self.column = column
        self.got = got
        self.allowed = allowed
        place = f"{path}:{line}" if line else str(path)
        where = f"{place}: column {column}" if column else place
        super().__init__(f"{where}: got {got!r}, allowed {allowed}")


class TerminalError(OperatorError):
    """There is no terminal that a person could drive from.

    Attributes:
        got: What there is instead, in words.
        allowed: What is allowed, in words.
    """

    def __init__(self, got: str, allowed: str) -> None:
        self.got = got
        self.allowed = allowed
        super().__init__(f"keyboard: got {got}, allowed {allowed}")
