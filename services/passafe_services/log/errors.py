"""Errors of reading and writing logs.

* ``LogFileError``
    * ``LogWriteError``: the log cannot be created or grown (no folder, no permission, disk full)
    * ``LogReadError``: the file is missing, empty or no MCAP file
"""

from pathlib import Path


class LogFileError(Exception):
    """Anything wrong with a log as a file.

    Attributes:
        path: The file.
        reason: What is wrong with it, in words.
    """

    def __init__(self, path: Path, reason: str) -> None:
        self.path = path
        self.reason = reason
        super().__init__(f"{path}: {reason}")


class LogWriteError(LogFileError):
    """The log cannot be created or grown."""

    def __init__(self, path: Path, error: OSError) -> None:
        self.errno = error.errno
        super().__init__(path, f"cannot write the log: {error.strerror or error}")


class LogReadError(LogFileError):
    """The file is missing, empty or no MCAP file."""
