"""Errors of log files; the tree of all errors is in ``passafe.errors``."""

from pathlib import Path

from passafe.errors import PassafeError


class LogFileError(PassafeError):
    """A log that cannot be used as a file, or as the log of a run.

    Attributes:
        path: The file.
        reason: What is wrong with it, in words.
    """

    def __init__(self, path: Path, reason: str) -> None:
        self.path = path
        self.reason = reason
        super().__init__(f"{path}: {reason}")


class LogWriteError(LogFileError):
    """A log that cannot be created or grown: no folder, no permission, a full disk.

    Attributes:
        errno: Number of the system's error.
        strerror: Its text.
    """

    def __init__(self, path: Path, error: OSError) -> None:
        self.errno = error.errno
        self.strerror = error.strerror or str(error)
        super().__init__(path, f"cannot write the log: {error.strerror or error}")


class LogReadError(LogFileError):
    """A file that is missing, empty or no MCAP file, or of which nothing is intact."""


class ForeignLogError(LogFileError):
    """An MCAP file without a channel of passafe."""
