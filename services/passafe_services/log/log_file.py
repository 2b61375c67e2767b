"""An MCAP file that grows safely: what is flushed survives a kill, and trouble of the disk has one type."""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from mcap.writer import CompressionType, Writer

from passafe_services.log.errors import LogWriteError

CHUNK_BYTES = 1024 * 1024
LIBRARY = "passafe"


class LogFile:
    """An MCAP file open for writing, zstd in chunks of 1 MB.

    Used as a context manager, which finishes the file. Once a write has failed nothing more is written to
    it: what was flushed before stays readable with ``recover``.

    Args:
        path: Where to write it.
        replace: Whether a file that is there already may be replaced.

    Attributes:
        path: Where it is.
        mcap: The writer; call it inside ``guarded()``, or answer its ``OSError`` with ``failed``.

    Raises:
        LogWriteError: The file cannot be created.
    """

    def __init__(self, path: Path, *, replace: bool = True) -> None:
        self.path = path
        try:
            self._raw = io.FileIO(path, "w" if replace else "x")
        except OSError as error:
            raise LogWriteError(path, error) from error
        self._stream = io.BufferedWriter(self._raw, buffer_size=CHUNK_BYTES)
        self.mcap = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        with self.guarded():
            self.mcap.start(library=LIBRARY)

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Turn a failed write into ``LogWriteError`` and close the file where it stands."""
        try:
            yield
        except OSError as error:
            raise self.failed(error) from error

    def failed(self, error: OSError) -> LogWriteError:
        """Close the file where it stands and return the error to raise."""
        # The raw file first: closing the buffer would try to write what just failed.
        with suppress(OSError):  # nothing more can be done about it, and the first error says it all
            self._raw.close()
        return LogWriteError(self.path, error)

    def flush(self) -> None:
        """End the chunk in progress and put everything so far on the disk.

        Raises:
            LogWriteError: The disk does not take it.
        """
        with self.guarded():
            self.mcap.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
            os.fdatasync(self._raw.fileno())

    def close(self) -> None:
        """Write the summary, so that the file is whole, and close it; nothing happens the second time.

        Raises:
            LogWriteError: The disk does not take it.
        """
        if self._raw.closed:
            return
        with self.guarded():
            self.mcap.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
            self._stream.flush()
            os.fdatasync(self._raw.fileno())
            self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
