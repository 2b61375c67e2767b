"""Refuse input files that would take memory without end: devices, pipes, and what is too large."""

import errno
import stat
from pathlib import Path
from typing import Final

MOST_BYTES: Final = 64 * 1024 * 1024
"""Largest input file: hours of commands at 1 kHz, or of a link's trace."""


def require_bounded(path: Path, most_bytes: int = MOST_BYTES) -> None:
    """Check that a file is a regular one and not too large, before it is opened.

    Raises:
        OSError: It is not, or it is not there.
    """
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        kind = "directory" if stat.S_ISDIR(found.st_mode) else "device or pipe"
        raise OSError(errno.EINVAL, f"a {kind}, not a regular file")
    if found.st_size > most_bytes:
        raise OSError(errno.EFBIG, f"{found.st_size} bytes, more than {most_bytes}")


def why_unreadable(error: Exception) -> str:
    """Return in words why a file of text cannot be read, without the numbers that only programmers know."""
    if isinstance(error, OSError):
        return error.strerror or str(error)
    if isinstance(error, UnicodeDecodeError):
        return "bytes that are no text in UTF-8"
    return str(error)
