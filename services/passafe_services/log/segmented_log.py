"""Log of a recording in one file after the other: by size, by time, and after a disk that could not be written."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from passafe_protocol.topics import SCENARIO

from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.errors import LogWriteError
from passafe_services.log.log_files import part_path
from passafe_services.log.log_writer import LogWriter, RunMetadata, topic_of_key


@dataclass(frozen=True, kw_only=True, slots=True)
class Rotation:
    """Limits of a file, at which the next one begins.

    Attributes:
        size_bytes: Size of a file at which it ends; ``None``: at no size.
        after_ns: Time after which a file ends, ns; ``None``: never.
    """

    size_bytes: int | None = None
    after_ns: int | None = None


class RawMessage(NamedTuple):
    """Message to log.

    Attributes:
        key: Key expression under which it was published.
        data: Its wire bytes.
        sequence: Its sequence number.
        wall_ns: Its wall time, ns.
    """

    key: str
    data: bytes
    sequence: int
    wall_ns: int


class SegmentedLog:
    """Log of one recording; every file of it can be read without the others.

    Messages that are not yet safe on the disk are kept: after a ``LogWriteError`` from ``write`` or ``flush``,
    ``reopen`` begins another file with them.

    Args:
        path: The first file; an existing one is replaced.
        metadata: Metadata records of every file, by name.
        chain: Chain of its checkpoints.
        rotation: When the next file begins.
        monotonic_ns: Clock of the rotation.

    Attributes:
        path: The file that is written.

    Raises:
        LogWriteError: The file cannot be created. Every method may raise it.
    """

    def __init__(
        self,
        path: Path,
        metadata: RunMetadata,
        chain: Chain,
        *,
        rotation: Rotation | None = None,
        monotonic_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.path = path
        self._first, self._part = path, 1
        self._metadata = metadata
        self._chain = chain
        self._rotation = Rotation() if rotation is None else rotation
        self._monotonic_ns = monotonic_ns
        self._unsafe: list[RawMessage] = []
        self._scenarios: dict[str, RawMessage] = {}
        self._is_scenario: dict[str, bool] = {}
        self._begun_ns = monotonic_ns()
        self._writer = LogWriter(path, metadata, chain=chain)
        self._safe = chain.end

    def write(self, *messages: RawMessage) -> None:
        """Log messages."""
        self._unsafe += messages
        for each in messages:
            if each.key not in self._is_scenario:
                self._is_scenario[each.key] = topic_of_key(each.key) is SCENARIO
            if self._is_scenario[each.key]:
                self._scenarios[each.key] = each
        self._log(messages)

    def flush(self, counts: RecorderCounts) -> None:
        """Make the messages safe on the disk, with a checkpoint; begin the next file if it is due."""
        self._writer.flush(counts)
        self._safe = self._chain.end
        self._unsafe.clear()
        rotation = self._rotation
        too_large = rotation.size_bytes is not None and self._writer.size_bytes >= rotation.size_bytes
        too_old = rotation.after_ns is not None and self._monotonic_ns() - self._begun_ns >= rotation.after_ns
        if (too_large or too_old) and self._writer.messages:
            self._writer.close(counts, final=False)
            self._safe = self._chain.end
            self._begin_next()

    def reopen(self, counts: RecorderCounts) -> None:
        """Go on in another file after a write error: with all messages that are not safe yet.

        Raises:
            LogWriteError: This is not possible yet; no other file is left behind.
        """
        safe = self._chain.end = self._safe
        self._begin_next()
        try:
            self._log(self._unsafe)
            self._writer.flush(counts)
        except LogWriteError:
            self._discard_next()
            self._safe = safe
            raise
        self._safe = self._chain.end
        self._unsafe.clear()

    def close(self, counts: RecorderCounts) -> None:
        """Finish the recording."""
        self._writer.close(counts, final=True)

    def _log(self, messages: Iterable[RawMessage]) -> None:
        write = self._writer.write
        for key, data, sequence, wall_ns in messages:
            write(key, data, sequence=sequence, wall_ns=wall_ns)

    def _begin_next(self) -> None:
        """Begin the next file: with the channels so far under the same numbers, and the scenario once more."""
        self.path = part_path(self._first, self._part + 1)
        self._part += 1
        channels = tuple(self._writer.channels)
        try:
            self._writer = LogWriter(self.path, self._metadata, chain=self._chain, part=self._part, channels=channels)
            self._safe = self._chain.end
            self._log(self._scenarios.values())
        except LogWriteError:
            self._discard_next()
            raise
        self._begun_ns = self._monotonic_ns()

    def _discard_next(self) -> None:
        """Remove the file that was begun in vain: all that it has is kept for the next one."""
        self.path.unlink(missing_ok=True)
        self._part -= 1
