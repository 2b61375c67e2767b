"""Reads the records of an MCAP file: of a truncated or damaged one, everything intact before and after the damage."""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, DataEnd, McapRecord, Schema
from mcap.writer import MCAP0_MAGIC

from passafe_services.log.errors import LogReadError
from passafe_services.log.record_scan import Damage, IntactRecord, described, scan_records


class LogReader:
    """Reader of one MCAP file, in the order in which its records were written.

    Args:
        path: The file.

    Attributes:
        path: The file.
        finished: After ``records`` has ended: whether the writer finished the file and all of it is intact.
        damage: After ``records`` has ended: what is not intact.
        tear: Description of the damage; empty if ``finished``.

    Raises:
        LogReadError: The file is missing, unreadable, empty or not an MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.finished = False
        self.tear = ""
        self.damage: list[Damage] = []
        try:
            with path.open("rb") as stream:
                beginning = stream.read(len(MCAP0_MAGIC))
                self._size_bytes = path.stat().st_size
                is_log = beginning == MCAP0_MAGIC or _has_contents(stream, self._size_bytes)
        except FileNotFoundError as error:
            raise LogReadError(path, "no such file") from error
        except OSError as error:
            raise LogReadError(path, f"cannot be read: {error.strerror or error}") from error
        if not beginning:
            raise LogReadError(path, "is empty")
        if not is_log:
            raise LogReadError(path, "is no MCAP file")

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
        self.finished, self.tear, self.damage = False, "", []
        ended, known = False, _Known()
        try:
            with self.path.open("rb") as stream:
                for found in scan_records(stream, self._size_bytes):
                    if isinstance(found, Damage):
                        yield found
                        if not self.damage:
                            yield from (each for each in self.definitions() if known.note(each))
                        self.damage.append(found)
                        continue
                    for record in found.records:
                        known.note(record)
                        ended = ended or isinstance(record, DataEnd)
                        yield record
        except OSError as error:
            raise LogReadError(self.path, f"cannot be read: {error.strerror or error}") from error
        self.finished = ended and not self.damage
        self.tear = described(self.damage, self._size_bytes, ended=ended)

    def definitions(self) -> Iterator[Schema | Channel]:
        """Yield every intact schema and channel of the whole file."""
        with self.path.open("rb") as stream:
            for found in scan_records(stream, self._size_bytes):
                for record in () if isinstance(found, Damage) else found.records:
                    if isinstance(record, Schema | Channel):
                        yield record


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
