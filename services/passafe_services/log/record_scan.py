"""Finds the intact records of an MCAP file, before and after damage."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import BinaryIO, Final, NamedTuple

from mcap.opcode import Opcode
from mcap.records import Chunk, McapRecord
from mcap.writer import MCAP0_MAGIC

from passafe_services.log.chunk import DAMAGE, RECORD_HEAD, chunk_contents, read_record, records_of_chunk

_WINDOW_BYTES: Final = 1 << 20
_CANDIDATE: Final = re.compile(rb"(?=([\x01-\x0f]).{4}\x00{4})", re.DOTALL)
"""Head of a record of less than 4 GiB, wherever it is."""
_KINDS: Final = {opcode.value: opcode.name.lower().replace("_", " ") for opcode in Opcode}
_SHOWN: Final = 3
"""Places of damage that are named in one line."""
_INSIDE_CHUNKS: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)


@dataclass(frozen=True, kw_only=True)
class Damage:
    """Bytes of a file that are no intact records.

    Attributes:
        start: Offset of the first of them.
        end: Offset after the last.
        reason: What is wrong with them, in words.
        first_ns: Earliest log time of a damaged chunk as its head says, ns; ``None`` if there is no such head.
        last_ns: The same, latest.
    """

    start: int
    end: int
    reason: str
    first_ns: int | None = None
    last_ns: int | None = None

    def __str__(self) -> str:
        return f"bytes {self.start} to {self.end}: {self.reason}"


class IntactRecord(NamedTuple):
    """Intact record outside of chunks.

    Attributes:
        start: Offset of its head.
        end: Offset after its contents.
        opcode: Its kind.
        records: What it is, a chunk's contents in its place if it is unpacked; empty for a message index.
    """

    start: int
    end: int
    opcode: int
    records: list[McapRecord]


def described(damage: Sequence[Damage], size_bytes: int, *, ended: bool) -> str:
    """Return a description of what is damaged in a file; empty if nothing is and its end was reached."""
    places = [str(each) for each in damage[:_SHOWN]]
    if len(damage) > _SHOWN:
        places.append(f"and {len(damage) - _SHOWN} more")
    if not ended:
        places.append("its end is missing")
    return f"of {size_bytes} bytes not all are intact: {'; '.join(places)}" if places else ""


def scan_records(stream: BinaryIO, size_bytes: int, *, unpack: bool = True) -> Iterator[IntactRecord | Damage]:
    """Yield the intact records of a file up to its footer, and the damage between them, in order of offsets.

    After damage the next record is searched for. Schemas, channels and messages count only where no chunk can contain
    them: those in a damaged chunk are not believed.

    Args:
        stream: The file, seekable.
        size_bytes: Its size.
        unpack: Whether chunks are unpacked; otherwise they come as they are, of the right length but not checked.

    Raises:
        OSError: It cannot be read.
    """
    scan = _Scan(stream, size_bytes)
    at = len(MCAP0_MAGIC)
    if scan.bytes_at(0, at) != MCAP0_MAGIC:
        at = scan.next_record(0)
        yield Damage(start=0, end=at, reason="not the first bytes of an MCAP file")
    while at < size_bytes:
        found = scan.record_at(at, unpack=unpack)
        if isinstance(found, IntactRecord):
            yield found
            if found.opcode == Opcode.FOOTER:
                return
            at = found.end
        else:
            start, at = at, scan.after_damage(at)
            yield Damage(start=start, end=at, reason=found.reason, first_ns=found.first_ns, last_ns=found.last_ns)


class _Broken(NamedTuple):
    """Reason for which no intact record is at some offset, and the times that a damaged chunk claims."""

    reason: str
    first_ns: int | None = None
    last_ns: int | None = None


class _Scan:
    """Reads records of a file at any offset."""

    def __init__(self, stream: BinaryIO, size_bytes: int) -> None:
        self._stream = stream
        self._size = size_bytes
        self._is_chunked: bool | None = None

    def bytes_at(self, at: int, length: int) -> bytes:
        """Return so many bytes, less at the end of the file."""
        self._stream.seek(at)
        return self._stream.read(length)

    def record_at(self, at: int, *, unpack: bool = True) -> IntactRecord | _Broken:
        """Return the record whose head is at an offset, or why there is none.

        A chunk that is not to be unpacked is unpacked all the same where its length is in doubt, to check it.
        """
        head = self.bytes_at(at, RECORD_HEAD.size)
        opcode, length = RECORD_HEAD.unpack(head) if len(head) == RECORD_HEAD.size else (Opcode.HEADER, self._size)
        end = at + RECORD_HEAD.size + length
        if not Opcode.HEADER <= opcode <= Opcode.DATA_END:
            return _Broken(f"a record of kind {opcode}, which MCAP does not define")
        if end > self._size:
            return _Broken("cut off")
        if opcode == Opcode.MESSAGE and self._chunks_from(at):  # no checksum covers it: a chunk whose kind was changed
            return _Broken("a message outside of the chunks")
        record = None
        try:
            record = read_record(opcode, self.bytes_at(at + RECORD_HEAD.size, length))
            records = [] if record is None else [record]
            if isinstance(record, Chunk) and (unpack or not self._may_begin_at(end)):
                inner = list(records_of_chunk(chunk_contents(record)))
                self._is_chunked = True
                records = inner if unpack else records
        except DAMAGE as error:
            times: tuple[int | None, int | None] = (None, None)
            if isinstance(record, Chunk) and 0 < record.message_start_time <= record.message_end_time:
                times = (record.message_start_time, record.message_end_time)
            return _Broken(f"{_KINDS[opcode]}: {str(error) or type(error).__name__}", *times)
        return IntactRecord(at, end, opcode, records)

    def _may_begin_at(self, at: int) -> bool:
        """Return whether the head of a record may be at an offset."""
        return _CANDIDATE.match(self.bytes_at(at, RECORD_HEAD.size)) is not None

    def after_damage(self, at: int) -> int:
        """Return where to go on after a record that is damaged: after its contents if its length is right."""
        head = self.bytes_at(at, RECORD_HEAD.size)
        if len(head) == RECORD_HEAD.size:
            end: int = at + RECORD_HEAD.size + RECORD_HEAD.unpack(head)[1]
            if end < self._size and isinstance(self.record_at(end), IntactRecord):
                return end
        return self.next_record(at + 1)

    def next_record(self, at: int) -> int:
        """Return the offset of the next intact record at or after one; the size of the file if there is none."""
        for offset, opcode in self._candidates(at):
            if opcode in _INSIDE_CHUNKS and self._chunks_from(at):
                continue
            if isinstance(self.record_at(offset), IntactRecord):
                return offset
        return self._size

    def _chunks_from(self, at: int) -> bool:
        """Return whether the file has chunks, as far as is known or comes after an offset."""
        if self._is_chunked is None:
            chunks = (offset for offset, opcode in self._candidates(at) if opcode == Opcode.CHUNK)
            self._is_chunked = any(isinstance(self.record_at(offset), IntactRecord) for offset in chunks)
        return self._is_chunked

    def _candidates(self, at: int) -> Iterator[tuple[int, int]]:
        """Yield offset and kind of everything that looks like the head of a record, from an offset on."""
        for begin in range(at, self._size, _WINDOW_BYTES):
            window = self.bytes_at(begin, _WINDOW_BYTES + RECORD_HEAD.size - 1)
            for match in _CANDIDATE.finditer(window):
                if match.start() < _WINDOW_BYTES:
                    yield begin + match.start(), match[1][0]
