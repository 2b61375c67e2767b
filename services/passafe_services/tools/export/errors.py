"""Errors of exports; the tree of all errors is in ``passafe.errors``."""

from pathlib import Path

from passafe.errors import PassafeError


class ExportError(PassafeError):
    """Output of an export that cannot be written.

    Attributes:
        path: The file or folder.
        errno: Number of the error of the operating system.
    """

    def __init__(self, path: Path, error: OSError) -> None:
        self.path = path
        self.errno = error.errno
        super().__init__(f"{path}: cannot be written: {error.strerror or error}")
