"""Encodes and decodes the messages of every topic; both directions validate.

The conversion is driven by the shapes of the records (``passafe_protocol.shapes``): a field added to
``passafe.proto`` and ``messages`` needs no change here. ``docs/wire-protocol.md`` describes the format.
"""

from functools import cache
from typing import Any, Final, NamedTuple, cast

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import DecodeError as ParseError
from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.unknown_fields import UnknownFieldSet

from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import is_intact, with_checksum
from passafe_protocol.errors import ChecksumError, DecodeError, InvalidMessageError, SchemaVersionError
from passafe_protocol.messages import SCHEMA_VERSION, Header, Message, Record
from passafe_protocol.shapes import RecordType, Shape, shape_of
from passafe_protocol.topics import TOPICS, Topic
from passafe_protocol.validation import check, member_of

MAX_MESSAGE_BYTES: Final = 1 << 20
"""Largest message; bounds the time and memory that a reader spends on one."""

_HEADER: Final = shape_of(Header)


class _Format(NamedTuple):
    """Record shape and protobuf type of one topic's messages."""

    topic: str
    shape: Shape
    message_type: type[ProtobufMessage]


_FORMAT_OF_BODY: Final[dict[RecordType, _Format]] = {
    topic.body: _Format(topic.name, shape_of(topic.body), getattr(passafe_pb2, topic.body.__name__)) for topic in TOPICS
}


def encode(header: Header, body: Message) -> bytes:
    """Encode a message, with this build's schema version in the header and the checksum at the end.

    Raises:
        InvalidMessageError: A field has a value that ``decode`` would refuse.
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
    data = with_checksum(message.SerializeToString())
    if len(data) > MAX_MESSAGE_BYTES:
        raise InvalidMessageError(topic, "body", f"{len(data)} bytes", f"at most {MAX_MESSAGE_BYTES} bytes")
    return data


def decode(topic: Topic, data: bytes) -> tuple[Header, Message]:
    """Decode a message received on ``topic`` into header and body; arbitrary bytes raise only the errors below.

    Raises:
        ChecksumError: The bytes were damaged.
        DecodeError: The bytes are not a message of the topic.
        SchemaVersionError: The message has another schema version.
        InvalidMessageError: A field has a value that is not allowed.
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
    """Return the schema of all messages as a serialized ``FileDescriptorSet``, as logs embed it."""
    descriptors = FileDescriptorSet()
    passafe_pb2.DESCRIPTOR.CopyToProto(descriptors.file.add())
    return descriptors.SerializeToString(deterministic=True)


def schema_name(topic: Topic) -> str:
    """Return the full protobuf name of the topic's message, such as ``passafe.v1.PlantState``."""
    return _FORMAT_OF_BODY[topic.body].message_type.DESCRIPTOR.full_name


def _fill(topic: str, shape: Shape, message: ProtobufMessage, record: Record, path: str) -> None:
    """Copy a record into its protobuf message, which raises on wrong types and numbers out of range."""
    index, name = 0, ""
    value = shape.read(record)
    try:
        for index, name in shape.plain:
            setattr(message, name, value[index])
        for index, name in shape.vectors:
            getattr(message, name).extend(value[index])
    except (TypeError, ValueError, OverflowError) as error:
        allowed = f"a value that protobuf accepts: {error}"
        raise InvalidMessageError(topic, path + name, value[index], allowed) from error
    for index, name, part in shape.parts:
        _fill(topic, part, getattr(message, name), value[index], f"{path}{name}.")
    for index, name, part in shape.lists:
        elements = getattr(message, name)
        for k, element in enumerate(value[index]):
            _fill(topic, part, elements.add(), element, f"{path}{name}[{k}].")


def _read(topic: str, shape: Shape, message: ProtobufMessage, path: str = "") -> Record:
    """Convert a protobuf message into a record with fields of the right types.

    Unknown fields are refused: protobuf would otherwise decode a state as an input, because the field numbers of
    their vectors coincide.
    """
    unknown = UnknownFieldSet(message)
    if len(unknown):
        got = f"field number {unknown[0].field_number}"
        allowed = f"the fields of schema version {SCHEMA_VERSION}"
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
