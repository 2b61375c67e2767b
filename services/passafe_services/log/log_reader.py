"""Reads the records of a log: of a truncated or damaged one, everything intact before and after the damage."""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

from mcap.opcode import Opcode
from mcap.records import Channel, DataEnd, McapRecord, Metadata, Schema
from mcap.well_known import MessageEncoding
from mcap.writer import MCAP0_MAGIC

from passafe_services.log.checkpoint import CHECKPOINT_RECORD, checkpoint_of
from passafe_services.log.errors import LogReadError
from passafe_services.log.log_files import files_of
from passafe_services.log.reading_state import ReadingState
from passafe_services.log.record_scan import Damage, IntactRecord, scan_records

UNKNOWN_SCHEMA: Final = 2**16 - 1
"""Schema of a channel that is known from a checkpoint alone."""


class LogReader:
    """Reader of the files of a recording, in the order in which its records were written.

    Args:
        path: The first file, or a folder that holds one recording (see ``log_files.files_of``).
        alone: Whether the file is read without others that continue it.

    Attributes:
        path: As given.
        files: The files.
        finished: After ``records`` has ended: whether the writer finished the log and all of it is intact.
        damage: After ``records`` has ended: what is not intact.
        tear: Description of the damage; empty if ``finished``.
        shortcomings: After ``records`` has ended: reasons for which checkpoints do not prove that nothing is missing.

    Raises:
        LogReadError: A file is missing, unreadable, empty or not an MCAP file.
    """

    def __init__(self, path: Path, *, alone: bool = False) -> None:
        self.path = path
        self.files = [path] if alone else files_of(path)
        self._state = ReadingState([(file, _size_of_log(file)) for file in self.files])

    @property
    def finished(self) -> bool:
        """See the class."""
        return self._state.finished

    @property
    def tear(self) -> str:
        """See the class."""
        return self._state.tear

    @property
    def damage(self) -> list[Damage]:
        """See the class."""
        return self._state.damage

    @property
    def shortcomings(self) -> list[str]:
        """See the class."""
        return self._state.audit.shortcomings

    def records(self) -> Iterator[McapRecord]:
        """Yield every intact record; chunks are replaced by their contents, message indexes are left out."""
        for item in self.items():
            if not isinstance(item, Damage):
                yield item

    def items(self) -> Iterator[McapRecord | Damage]:
        """Yield every intact record as ``records`` does, and the damage between them.

        After damage that may have destroyed the first definition of a channel, the definitions that come later in the
        file are yielded before anything else.
        """
        state = self._state = ReadingState([(file, _size_of_log(file)) for file in self.files])
        for number, file in enumerate(self.files):
            try:
                yield from _items(file, number, state)
            except OSError as error:
                raise LogReadError(file, f"cannot be read: {error.strerror or error}") from error


def definitions(file: Path) -> Iterator[Schema | Channel]:
    """Yield every intact schema and channel of a file, and the channels that its checkpoints name."""
    named: dict[int, str] = {}
    with file.open("rb") as stream:
        for found in scan_records(stream, file.stat().st_size):
            for record in () if isinstance(found, Damage) else found.records:
                if isinstance(record, Schema | Channel):
                    yield record
                elif isinstance(record, Metadata) and record.name == CHECKPOINT_RECORD:
                    checkpoint = checkpoint_of(record.metadata)
                    named |= {} if checkpoint is None else checkpoint.channels
    for number, key in named.items():
        yield Channel(number, key, MessageEncoding.Protobuf, {}, UNKNOWN_SCHEMA)


def _items(file: Path, number: int, state: ReadingState) -> Iterator[McapRecord | Damage]:
    known, is_damaged = _Known(), False
    with file.open("rb") as stream:
        for found in scan_records(stream, state.bases[number + 1] - state.bases[number]):
            if isinstance(found, Damage):
                state.note_damage(found, number)
                yield found
                if not is_damaged:
                    yield from (each for each in definitions(file) if known.note(each))
                is_damaged = True
                continue
            for record in found.records:
                known.note(record)
                if isinstance(record, DataEnd):
                    state.note_end(number)
                elif isinstance(record, Metadata):
                    state.note_metadata(record.name, record.metadata)
                yield record


def _size_of_log(path: Path) -> int:
    """Return the size of a file.

    Raises:
        LogReadError: It is missing, a device or pipe, unreadable, empty or not an MCAP file.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):  # to open a pipe waits for its writer
        raise LogReadError(path, "is a device or pipe, not a regular file")
    try:
        with path.open("rb") as stream:
            beginning, size_bytes = stream.read(len(MCAP0_MAGIC)), path.stat().st_size
            is_log = beginning == MCAP0_MAGIC or _has_contents(stream, size_bytes)
    except FileNotFoundError as error:
        raise LogReadError(path, "no such file") from error
    except OSError as error:
        raise LogReadError(path, f"cannot be read: {error.strerror or error}") from error
    if not beginning:
        raise LogReadError(path, "is empty")
    if not is_log:
        raise LogReadError(path, "is no MCAP file")
    return size_bytes


class _Known:
    """Schemas and channels met so far, by their numbers."""

    def __init__(self) -> None:
        self._found: set[tuple[type[McapRecord], int]] = set()

    def note(self, record: McapRecord) -> bool:
        """Remember a record; return whether it defines something new."""
        if not isinstance(record, Schema | Channel) or (type(record), record.id) in self._found:
            return False
        self._found.add((type(record), record.id))
        return True


def _has_contents(stream: BinaryIO, size_bytes: int) -> bool:
    """Return whether a file without the first bytes of a log is one all the same."""
    found = (each.opcode for each in scan_records(stream, size_bytes) if isinstance(each, IntactRecord))
    return any(opcode in (Opcode.HEADER, Opcode.CHUNK) for opcode in found)
