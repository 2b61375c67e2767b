"""Decodes a stretch of a log's records into tables, one for each topic: the work of a worker process of a pass."""

import struct
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any, Final, NamedTuple, TypeAlias

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message
from passafe_protocol import codec
from passafe_protocol.topics import TOPIC_OF_NAME, Topic

from passafe_services.log.chunk import DAMAGE, chunk_contents
from passafe_services.log.column import Column
from passafe_services.log.column_records import records_of
from passafe_services.log.log_writer import topic_of_key
from passafe_services.log.message_columns import RECORD, WIRE, ColumnDecoder, objects
from passafe_services.log.message_field import fields_of
from passafe_services.log.record_scan import Damage

ORDER_FIELDS: Final = ("header.source", "header.epoch", "header.sequence", "header.wall_ns")
"""Fields that every table has: by them messages are put in order."""

Wants: TypeAlias = Mapping[str, Collection[str]]
"""Paths of the wanted columns by name of the topic, besides ``ORDER_FIELDS``."""

LEAST_IN_COLUMNS: Final = 64
"""Messages of a stretch from which on records are made of columns: of fewer the codec makes them sooner."""

_CHUNK_HEAD_BYTES: Final = 49
"""Size of a chunk's record without the name of its compression and its data."""
_HEAD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")


class Stretch(NamedTuple):
    """Records of a log that follow each other.

    Attributes:
        records: Chunks as they are in the file, and channels and messages outside of chunks.
        read_bytes: Bytes of the file up to the end of each.
    """

    records: Sequence[Chunk | Channel | Message]
    read_bytes: Sequence[int]


@dataclass(kw_only=True)
class DecodedStretch:
    """Messages of a stretch.

    Attributes:
        tables: Columns by path, by name of the topic.
        undecodable: Number of messages that are not valid for their topic, by its name.
        channels: Key of every channel that the stretch registers.
        unknown: Channels of its messages that it does not register, and that were not known.
        damage: Chunks that are damaged.
        read_bytes: Bytes of the file up to the end of the stretch.
    """

    tables: dict[str, dict[str, Column]] = field(default_factory=dict)
    undecodable: dict[str, int] = field(default_factory=dict)
    channels: dict[int, str] = field(default_factory=dict)
    unknown: set[int] = field(default_factory=set)
    damage: list[Damage] = field(default_factory=list)
    read_bytes: int = 0


_decoders: dict[str, ColumnDecoder] = {}  # of this process: layouts recur from stretch to stretch


def decode_stretch(stretch: Stretch, channels: Mapping[int, str], wants: Wants) -> DecodedStretch:
    """Decode the messages of a stretch.

    Args:
        stretch: The records.
        channels: Keys of the channels that were registered before, by number.
        wants: Columns that are wanted.
    """
    found = DecodedStretch()
    messages: dict[str, list[bytes]] = {}
    topics: dict[int, Topic | None] = {number: topic_of_key(key) for number, key in channels.items()}
    for record, read_bytes in zip(stretch.records, stretch.read_bytes, strict=True):
        found.read_bytes = read_bytes
        try:
            inner = [*_in_chunk(record)] if isinstance(record, Chunk) else [record]
        except DAMAGE as error:
            found.damage.append(_damaged(record, read_bytes, error))
            continue
        for one in inner:
            if isinstance(one, Channel):
                if one.id not in topics:
                    topics[one.id] = topic_of_key(one.topic)
                    found.channels[one.id] = one.topic
                continue
            number, data = one if isinstance(one, tuple) else (one.channel_id, one.data)
            topic = topics.get(number)
            if topic is not None:
                messages.setdefault(topic.name, []).append(data)
            elif number not in topics:
                found.unknown.add(number)
    for name, of_topic in messages.items():
        _decode(TOPIC_OF_NAME[name], of_topic, wants.get(name, ()), found)
    return found


def _decode(topic: Topic, messages: Sequence[bytes], paths: Collection[str], found: DecodedStretch) -> None:
    decoder = _decoders.setdefault(topic.name, ColumnDecoder(topic))
    wanted = {*ORDER_FIELDS, *paths} - {RECORD, WIRE}
    makes_records = RECORD in paths and len(messages) >= LEAST_IN_COLUMNS
    table = decoder.decode(messages, {*wanted, *fields_of(topic)} if makes_records else wanted)
    if table.valid.size < len(messages):
        found.undecodable[topic.name] = len(messages) - table.valid.size
    if not table.valid.size:
        return
    found.tables[topic.name] = columns = {path: table.columns[path] for path in wanted}
    wire = [messages[number] for number in table.valid.tolist()] if RECORD in paths or WIRE in paths else []
    if WIRE in paths:
        columns[WIRE] = objects(wire)
    if makes_records:
        columns[RECORD] = objects(records_of(topic, table.columns))
    elif RECORD in paths:
        columns[RECORD] = objects([codec.decode(topic, data) for data in wire])


def _in_chunk(chunk: Chunk) -> Iterator[Any]:
    """Yield the channels of a chunk, and number of channel and data of its messages.

    Raises:
        DAMAGE: The chunk is damaged.
    """
    data = chunk_contents(chunk)
    at, size = 0, len(data)
    while at < size:
        if at + _HEAD.size > size:
            raise EndOfFile
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        end = at + length
        if end > size:
            raise EndOfFile
        if opcode == Opcode.MESSAGE:
            if length < _MESSAGE.size:
                raise EndOfFile
            yield _MESSAGE.unpack_from(data, at)[0], data[at + _MESSAGE.size : end]
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(data[at:end])))
        at = end


def _damaged(record: Chunk | Channel | Message, end: int, error: Exception) -> Damage:
    reason = f"chunk: {str(error) or type(error).__name__}"
    if not isinstance(record, Chunk):
        return Damage(start=end, end=end, reason=reason)
    start = end - _CHUNK_HEAD_BYTES - len(record.compression.encode()) - len(record.data)
    times = record.message_start_time, record.message_end_time
    return Damage(start=start, end=end, reason=reason, first_ns=times[0], last_ns=times[1])
