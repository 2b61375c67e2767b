"""Reads the contents of one MCAP record strictly: whatever is not exactly a record of its kind is refused."""

import struct
from collections.abc import Iterator
from io import BytesIO
from typing import Final

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import get_chunk_data_stream

RECORD_HEAD: Final = struct.Struct("<BQ")
"""Opcode and length of a record."""
CHUNK_LIMIT_BYTES: Final = 2**30
"""Largest chunk that is decompressed: a damaged size must not take the machine's memory."""
DAMAGE: Final = (McapError, zstandard.ZstdError, struct.error, ValueError, OverflowError, MemoryError, RuntimeError)
"""Errors of damaged contents; ``ValueError``: checksum and UTF-8, ``RuntimeError``: LZ4."""

_MESSAGE_HEAD: Final = struct.Struct("<HIQQ")
_READERS: Final = {
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.DATA_END: DataEnd.read,
    Opcode.FOOTER: Footer.read,
    Opcode.HEADER: Header.read,
    Opcode.METADATA: Metadata.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.STATISTICS: Statistics.read,
    Opcode.SUMMARY_OFFSET: SummaryOffset.read,
}


class _StrictStream(ReadDataStream):
    """Stream that refuses to return less than was asked for."""

    def read(self, length: int) -> bytes:
        data = super().read(length)
        if len(data) != length:
            raise ValueError(f"length: got {length} bytes, allowed {len(data)}, the rest of the record")
        return data


def read_record(opcode: int, content: bytes) -> McapRecord | None:
    """Return the record with these contents; ``None`` for a message index, which is not kept.

    Raises:
        Exception: One of ``DAMAGE``: the contents are not of such a record.
    """
    if opcode == Opcode.MESSAGE:
        return _message(content, 0, len(content))
    if opcode == Opcode.MESSAGE_INDEX:
        _require_message_index(content)
        return None
    stream = _StrictStream(BytesIO(content))
    record: McapRecord = _READERS[Opcode(opcode)](stream)
    if stream.count != len(content):
        raise ValueError(f"record: got {len(content)} bytes, allowed {stream.count}")
    return record


def chunk_contents(chunk: Chunk) -> bytes:
    """Return the records of a chunk as bytes, decompressed and checked.

    Raises:
        Exception: One of ``DAMAGE``: size or checksum is not that of the chunk.
    """
    claimed = [chunk.uncompressed_size]
    if chunk.compression == "zstd":
        claimed.append(zstandard.frame_content_size(chunk.data))
    if max(claimed) > CHUNK_LIMIT_BYTES:
        raise ValueError(f"chunk: got {max(claimed)} bytes, allowed {CHUNK_LIMIT_BYTES}")
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    if length != chunk.uncompressed_size:
        raise ValueError(f"chunk: got {length} bytes, allowed {chunk.uncompressed_size} as it says")
    return stream.read(length)


def records_of_chunk(contents: bytes) -> Iterator[McapRecord]:
    """Yield the schemas, channels and messages of a chunk.

    Args:
        contents: Its records as bytes.

    Raises:
        Exception: One of ``DAMAGE``: they are no records.
    """
    at, end = 0, len(contents)
    while at < end:
        opcode, length = RECORD_HEAD.unpack_from(contents, at)
        begin = at + RECORD_HEAD.size
        at = begin + length
        if at > end:
            raise ValueError(f"record in a chunk: got {length} bytes, allowed {end - begin}")
        if opcode == Opcode.MESSAGE:
            yield _message(contents, begin, at)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            record = read_record(opcode, contents[begin:at])
            if record is not None:
                yield record


def _message(contents: bytes, begin: int, end: int) -> Message:
    channel_id, sequence, log_time, publish_time = _MESSAGE_HEAD.unpack_from(contents, begin)
    data = contents[begin + _MESSAGE_HEAD.size : end]
    return Message(channel_id, log_time, data, publish_time, sequence)


def _require_message_index(content: bytes) -> None:
    _, length = struct.Struct("<HI").unpack_from(content)
    if length % 16 or length + 6 != len(content):
        raise ValueError(f"message index: got {length} bytes of entries, allowed {len(content) - 6}")
