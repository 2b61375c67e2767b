"""Reads the records of an MCAP file, complete or truncated."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from mcap.exceptions import McapError
from mcap.records import Footer, McapRecord
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from passafe_services.log.errors import LogReadError

DAMAGE: Final = (McapError, ZstdError, struct.error, ValueError, OverflowError, MemoryError)
"""Errors of the stream reader on truncated or damaged data; ``ValueError``: CRC and UTF-8."""


class LogReader:
    """Reader of one MCAP file, in the order in which its records were written.

    Args:
        path: The file.

    Attributes:
        path: The file.
        finished: After ``records`` has ended: whether the end of the file was reached.
        tear: Description of the damage at which reading stopped; empty if ``finished``.

    Raises:
        LogReadError: The file is missing, unreadable, empty or not an MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.finished = False
        self.tear = ""
        try:
            with path.open("rb") as stream:
                beginning = stream.read(len(MCAP0_MAGIC))
            self._size_bytes = path.stat().st_size
        except FileNotFoundError as error:
            raise LogReadError(path, "no such file") from error
        except OSError as error:
            raise LogReadError(path, f"cannot be read: {error.strerror or error}") from error
        if not beginning:
            raise LogReadError(path, "is empty")
        if beginning != MCAP0_MAGIC:
            raise LogReadError(path, "is no MCAP file")

    def records(self) -> Iterator[McapRecord]:
        """Yield every complete record; chunks are replaced by their contents."""
        self.finished = False
        self.tear = ""
        with self.path.open("rb") as stream:
            reader = StreamReader(stream, validate_crcs=True, record_size_limit=self._size_bytes)
            try:
                for record in reader.records:
                    self.finished = self.finished or isinstance(record, Footer)
                    yield record
            except OSError as error:
                raise LogReadError(self.path, f"cannot be read: {error.strerror or error}") from error
            except DAMAGE as error:
                if not self.finished:
                    self.tear = f"{type(error).__name__} after {stream.tell()} of {self._size_bytes} bytes"
