"""Decodes a stretch of a log's records into tables, one for each topic: the work of a worker process of a pass."""

import struct
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message
from passafe_protocol import codec
from passafe_protocol.topics import TOPIC_OF_NAME, Topic

from passafe_services.log.chunk import DAMAGE, chunk_contents
from passafe_services.log.column import Column, Numbers
from passafe_services.log.column_records import records_of
from passafe_services.log.log_writer import topic_of_key
from passafe_services.log.message_columns import CHECKSUM, RECORD, WIRE, ColumnDecoder, objects
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
_MESSAGE: Final = int(Opcode.MESSAGE)
_CHANNEL: Final = int(Opcode.CHANNEL)
_MESSAGE_HEAD_BYTES: Final = 22
"""Size of a message's channel, sequence number and times."""


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


Decode: TypeAlias = Callable[[Stretch, Mapping[int, str]], DecodedStretch]
"""Decodes a stretch, given the keys of the channels that were registered before."""

_decoders: dict[str, ColumnDecoder] = {}  # of this process: layouts recur from stretch to stretch


def decode_stretch(
    stretch: Stretch, channels: Mapping[int, str], wants: Wants, *, wanted_only: bool = False
) -> DecodedStretch:
    """Decode the messages of a stretch.

    Args:
        stretch: The records.
        channels: Keys of the channels that were registered before, by number.
        wants: Columns that are wanted.
        wanted_only: Whether messages of topics without an entry in ``wants`` are left out.
    """
    found = DecodedStretch()
    messages = _MessageLists(channels, wants.keys() if wanted_only else TOPIC_OF_NAME.keys())
    for record, read_bytes in zip(stretch.records, stretch.read_bytes, strict=True):
        found.read_bytes = read_bytes
        if isinstance(record, Channel):
            messages.register(record)
        elif isinstance(record, Message):
            messages.of_channel(record.channel_id).append(record.data)
        else:
            try:
                messages.add_chunk(record)
            except DAMAGE as error:
                found.damage.append(_damaged(record, read_bytes, error))
    found.channels, found.unknown = messages.registered, messages.unknown
    for name, of_topic in messages.of_topic.items():
        if of_topic:
            _decode(TOPIC_OF_NAME[name], of_topic, wants.get(name, ()), found)
    return found


class _MessageLists:
    """Messages of a stretch by the name of their topic, in the order of the file.

    Args:
        channels: Keys of the channels that were registered before, by number.
        wanted: Names of the topics whose messages are kept.

    Attributes:
        of_topic: Wire bytes by name of the topic.
        registered: Keys of the channels that were registered here, by number.
        unknown: Numbers of channels with messages that nobody registered.
    """

    def __init__(self, channels: Mapping[int, str], wanted: Collection[str]) -> None:
        self.of_topic: dict[str, list[bytes]] = {}
        self.registered: dict[int, str] = {}
        self.unknown: set[int] = set()
        self._wanted = wanted
        self._of_channel: dict[int, list[bytes] | None] = {number: self._list(key) for number, key in channels.items()}

    def register(self, channel: Channel) -> None:
        """Take a channel that a record describes, unless it is known."""
        if channel.id not in self._of_channel:
            self._of_channel[channel.id] = self._list(channel.topic)
            self.registered[channel.id] = channel.topic

    def of_channel(self, number: int) -> list[bytes]:
        """Return the list for the messages of a channel; one that nobody sees, if none is wanted."""
        if number not in self._of_channel:
            self.unknown.add(number)
        found = self._of_channel.get(number)
        return [] if found is None else found

    def add_chunk(self, chunk: Chunk) -> None:
        """Take the messages and channels of a chunk: all of them, or none.

        Raises:
            DAMAGE: The chunk is damaged.
        """
        lengths = {name: len(messages) for name, messages in self.of_topic.items()}
        registered, unknown = dict(self.registered), set(self.unknown)
        try:
            self._add_records(chunk_contents(chunk))
        except DAMAGE:
            for name, messages in self.of_topic.items():
                del messages[lengths.get(name, 0) :]
            for number in self.registered.keys() - registered.keys():
                del self._of_channel[number]
            self.registered, self.unknown = registered, unknown
            raise

    def _add_records(self, data: bytes) -> None:
        of_channel = self._of_channel
        at, size = 0, len(data)
        while at < size:
            if at + _HEAD.size > size:
                raise EndOfFile
            opcode, length = _HEAD.unpack_from(data, at)
            begin = at + _HEAD.size
            at = begin + length
            if at > size:
                raise EndOfFile
            if opcode == _MESSAGE:
                if length < _MESSAGE_HEAD_BYTES:
                    raise EndOfFile
                number = data[begin] | data[begin + 1] << 8
                messages = of_channel.get(number)
                if messages is not None:
                    messages.append(data[begin + _MESSAGE_HEAD_BYTES : at])
                elif number not in of_channel:
                    self.unknown.add(number)
            elif opcode == _CHANNEL:
                self.register(Channel.read(ReadDataStream(BytesIO(data[begin:at]))))

    def _list(self, key: str) -> list[bytes] | None:
        topic = topic_of_key(key)
        if topic is None or topic.name not in self._wanted:
            return None
        return self.of_topic.setdefault(topic.name, [])


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
    columns[CHECKSUM] = _checksums([messages[number][-4:] for number in table.valid.tolist()])
    wire = [messages[number] for number in table.valid.tolist()] if RECORD in paths or WIRE in paths else []
    if WIRE in paths:
        columns[WIRE] = objects(wire)
    if makes_records:
        columns[RECORD] = objects(records_of(topic, table.columns))
    elif RECORD in paths:
        columns[RECORD] = objects([codec.decode(topic, data) for data in wire])


def _checksums(ends: Sequence[bytes]) -> Numbers:
    """Return the numbers in the last four bytes of messages, shape (N,)."""
    return np.frombuffer(b"".join(ends), dtype="<u4")


def _damaged(record: Chunk | Channel | Message, end: int, error: Exception) -> Damage:
    reason = f"chunk: {str(error) or type(error).__name__}"
    if not isinstance(record, Chunk):
        return Damage(start=end, end=end, reason=reason)
    start = end - _CHUNK_HEAD_BYTES - len(record.compression.encode()) - len(record.data)
    times = record.message_start_time, record.message_end_time
    return Damage(start=start, end=end, reason=reason, first_ns=times[0], last_ns=times[1])
