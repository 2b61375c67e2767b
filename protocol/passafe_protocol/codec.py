"""Messages to bytes and back, for every topic of the table; both ways validate.

The conversion is driven by the shapes of the records (``passafe_protocol.shapes``), so that a field added to
``passafe.proto`` and ``messages.py`` needs nothing here. ``docs/wire-protocol.md`` describes the format.
"""

from functools import cache
from typing import Any, Final, NamedTuple, cast

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError as ParseError
from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.unknown_fields import UnknownFieldSet

from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import is_intact, sealed
from passafe_protocol.errors import ChecksumError, DecodeError, InvalidMessageError, SchemaVersionError
from passafe_protocol.messages import SCHEMA_VERSION, Header, Message, Record
from passafe_protocol.shapes import RecordType, Shape, shape_of
from passafe_protocol.topics import TOPICS, Topic
from passafe_protocol.validation import check, member_of

MAX_MESSAGE_BYTES: Final = 1 << 20
"""Size of the largest message; bounds the time and memory that a reader spends on one."""

_HEADER: Final = shape_of(Header)


class _Format(NamedTuple):
    """How the messages of one topic are converted."""

    topic: str
    shape: Shape
    message_type: type[ProtobufMessage]


def _format_of(topic: Topic) -> _Format:
    body_type: RecordType = topic.body
    return _Format(
        topic=topic.name,
        shape=shape_of(body_type),
        message_type=getattr(passafe_pb2, body_type.__name__),
    )


_FORMAT_OF_BODY: Final[dict[RecordType, _Format]] = {topic.body: _format_of(topic) for topic in TOPICS}


def encode(header: Header, body: Message) -> bytes:
    """Bytes of a message, its header stamped with this build's schema version, its checksum at the end.

    Raises:
        InvalidMessageError: If a field holds what it may not; nothing that ``decode`` would refuse leaves.
    """
    if type(body) not in _FORMAT_OF_BODY:
        raise InvalidMessageError("no topic", "body", type(body).__name__, "a message of the topic table")
    topic, shape, message_type = _FORMAT_OF_BODY[type(body)]
    message: Any = message_type()
    message.header.schema_version = SCHEMA_VERSION
    _fill(topic, _HEADER, message.header, header, "header.")
    _fill(topic, shape, message, body, "")
    check(topic, _HEADER, header, "header.")
    check(topic, shape, body)
    data = sealed(message.SerializeToString())
    if len(data) > MAX_MESSAGE_BYTES:
        raise InvalidMessageError(topic, "body", f"{len(data)} bytes", f"at most {MAX_MESSAGE_BYTES} bytes")
    return data


def decode(topic: Topic, data: bytes) -> tuple[Header, Message]:
    """Header and body of a message that arrived on ``topic``; no bytes raise anything but the errors below.

    Raises:
        ChecksumError: If the bytes are not those that were sent.
        DecodeError: If they are no message of the topic.
        SchemaVersionError: If they are one of another schema version.
        InvalidMessageError: If a field holds what it may not.
    """
    if len(data) > MAX_MESSAGE_BYTES:
        raise DecodeError(topic.name, len(data), f"more than {MAX_MESSAGE_BYTES} bytes")
    if not is_intact(data):
        raise ChecksumError(topic.name, len(data))
    _, shape, message_type = _FORMAT_OF_BODY[topic.body]
    try:
        message: Any = message_type.FromString(data)
    except ParseError as error:
        raise DecodeError(topic.name, len(data), str(error)) from error
    if not message.HasField("header"):
        raise DecodeError(topic.name, len(data), "no header")
    version = message.header.schema_version
    if version != SCHEMA_VERSION:
        raise SchemaVersionError(topic.name, version, SCHEMA_VERSION)
    header = _read(topic.name, _HEADER, message.header)
    body = _read(topic.name, shape, message)
    check(topic.name, _HEADER, header, "header.")
    check(topic.name, shape, body)
    return cast("Header", header), cast("Message", body)


@cache
def file_descriptor_set() -> bytes:
    """Schema of every message as a serialized ``FileDescriptorSet``: what a log carries to explain itself."""
    descriptors = FileDescriptorSet()
    passafe_pb2.DESCRIPTOR.CopyToProto(descriptors.file.add())
    return descriptors.SerializeToString(deterministic=True)


def schema_name(topic: Topic) -> str:
    """Full protobuf name of the topic's message, such as ``passafe.v1.PlantState``."""
    return _FORMAT_OF_BODY[topic.body].message_type.DESCRIPTOR.full_name


def _fill(topic: str, shape: Shape, message: ProtobufMessage, record: Record, path: str) -> None:
    """Copy a record into its protobuf message, which refuses wrong types and numbers out of range."""
    index, name = 0, ""
    value = shape.read(record)
    try:
        for index, name in shape.plain:
            setattr(message, name, value[index])
        for index, name in shape.vectors:
            getattr(message, name).extend(value[index])
    except (TypeError, ValueError, OverflowError) as error:
        allowed = f"what protobuf takes: {error}"
        raise InvalidMessageError(topic, path + name, value[index], allowed) from error
    for index, name, part in shape.parts:
        _fill(topic, part, getattr(message, name), value[index], f"{path}{name}.")
    for index, name, part in shape.lists:
        elements = getattr(message, name)
        for place, element in enumerate(value[index]):
            _fill(topic, part, elements.add(), element, f"{path}{name}[{place}].")


def _read(topic: str, shape: Shape, message: ProtobufMessage, path: str = "") -> Record:
    """Record of a protobuf message, its fields of the right types.

    Fields that the message does not have are refused: protobuf would otherwise read a state as an input,
    since the numbers of their vectors agree.
    """
    unknown = UnknownFieldSet(message)
    if len(unknown):
        got = f"field number {unknown[0].field_number}"
        allowed = f"its fields of schema version {SCHEMA_VERSION}"
        raise InvalidMessageError(topic, shape.record_type.__name__, got, allowed)
    values = list(shape.read(message))
    for index, _ in shape.vectors:
        values[index] = tuple(values[index][:])  # the slice copies in one go, iteration would call per number
    for index, name, members in shape.enums:
        values[index] = member_of(topic, path + name, values[index], members)
    for index, name, part in shape.parts:
        values[index] = _read(topic, part, values[index], f"{path}{name}.")
    for index, name, part in shape.lists:
        elements = enumerate(values[index])
        values[index] = tuple([_read(topic, part, element, f"{path}{name}[{k}].") for k, element in elements])
    return shape.make(*values)
