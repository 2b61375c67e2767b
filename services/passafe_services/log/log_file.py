"""MCAP file open for writing: flushed data survives a kill, and every write error is a ``LogWriteError``."""

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

from mcap.writer import CompressionType, Writer

from passafe_services.log.errors import LogWriteError

CHUNK_BYTES = 1024 * 1024
LIBRARY = "passafe"


@contextmanager
def in_place_of(path: Path, *, replace: bool = False) -> Iterator[Path]:
    """Yield the path of a file to write, which becomes ``path`` at the end of the block; after an error it is removed.

    Args:
        path: The file.
        replace: Whether it may exist, and is replaced then; of a link the file that it leads to.

    Raises:
        LogWriteError: ``path`` exists, at the beginning or at the end, or cannot become a file.
    """
    place = Path(os.path.realpath(path)) if replace else path
    fresh = place.with_name(f".{place.name}.part")
    try:
        if path.exists() and not replace:
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))
        fresh.unlink(missing_ok=True)  # of a recovery that was killed
        try:
            yield fresh
            if replace:
                fresh.replace(place)
            else:
                _become(fresh, path)
        finally:
            fresh.unlink(missing_ok=True)
    except OSError as error:
        raise LogWriteError(path, error) from error
    except LogWriteError as error:
        raise LogWriteError(path, OSError(error.errno, error.strerror)) from error


def _become(fresh: Path, path: Path) -> None:
    """Give a file its name, which nothing else may have."""
    try:
        os.link(fresh, path)  # unlike a rename it replaces nothing
    except OSError as error:
        if error.errno not in (errno.EPERM, errno.ENOTSUP, errno.EMLINK, errno.ENOSYS):
            raise
        path.touch(exist_ok=False)  # a file system without hard links
        fresh.replace(path)


def _synchronize(folder: Path) -> None:
    """Make the names in a folder safe on the disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class LogFile:
    """MCAP file open for writing, compressed with zstd in chunks of 1 MB.

    Use it as a context manager, which finishes the file. After a failed write nothing more is written: the file ends
    with the data flushed before, which ``recover`` completes.

    Args:
        path: Path of the file.
        replace: Whether an existing file may be replaced.

    Attributes:
        path: Path of the file.
        mcap: The writer; call it inside ``guarded()``, or handle its ``OSError`` with ``failed``.

    Raises:
        LogWriteError: The file cannot be created.
    """

    def __init__(self, path: Path, *, replace: bool = True) -> None:
        self.path = path
        try:
            self._raw = io.FileIO(path, "w" if replace else "x")
        except OSError as error:
            raise LogWriteError(path, error) from error
        self._safe_bytes = 0
        self._stream = io.BufferedWriter(self._raw, buffer_size=CHUNK_BYTES)
        self.mcap = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        with self.guarded():
            self.mcap.start(library=LIBRARY)
            _synchronize(path.parent)  # of a file without a name in its folder nothing would be left after a crash

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Turn a failed write into ``LogWriteError`` and close the unfinished file."""
        try:
            yield
        except OSError as error:
            raise self.failed(error) from error

    def failed(self, error: OSError) -> LogWriteError:
        """Cut the file down to what is safe on the disk, close it and return the error to raise."""
        # The raw file first: closing the buffer would retry the failed write.
        with suppress(OSError):  # the first error is the one to report
            os.ftruncate(self._raw.fileno(), self._safe_bytes)
        with suppress(OSError):
            self._raw.close()
        return LogWriteError(self.path, error)

    def flush(self) -> None:
        """End the current chunk, synchronize the file to disk, and check that it is still there.

        Raises:
            LogWriteError: The file cannot be written, or was removed, moved or replaced.
        """
        with self.guarded():
            self.mcap.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
            os.fdatasync(self._raw.fileno())
            self._require_in_place()
            self._safe_bytes = os.fstat(self._raw.fileno()).st_size

    def close(self) -> None:
        """Write the summary, which completes the file, and close it; a second call has no effect.

        Raises:
            LogWriteError: The file cannot be written.
        """
        if self._raw.closed:
            return
        with self.guarded():
            self.mcap.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
            self._stream.flush()
            os.fdatasync(self._raw.fileno())
            self._require_in_place()
            self._stream.close()

    @property
    def closed(self) -> bool:
        """True if nothing can be written any more."""
        return self._raw.closed

    @property
    def size_bytes(self) -> int:
        """Size of what is safe on the disk."""
        return self._safe_bytes

    def _require_in_place(self) -> None:
        """Check that the path still leads to this file: one that was removed can be written on without an error."""
        try:
            in_place = os.path.samestat(self.path.stat(), os.fstat(self._raw.fileno()))
        except FileNotFoundError:
            in_place = False
        if not in_place:
            raise OSError(errno.ENOENT, "it was removed, moved or replaced while it was written")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.close()
