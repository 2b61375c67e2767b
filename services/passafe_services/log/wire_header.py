"""Reads the header of a message without decoding its body, for the recorder."""

from typing import Any, Final

from google.protobuf.message import DecodeError as ParseError
from google.protobuf.message import Message as ProtobufMessage
from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import is_intact
from passafe_protocol.messages import SCHEMA_VERSION, Header
from passafe_protocol.shapes import shape_of
from passafe_protocol.topics import TOPICS, Topic

_MESSAGE_OF_TOPIC: Final[dict[str, type[ProtobufMessage]]] = {
    topic.name: getattr(passafe_pb2, topic.body.__name__) for topic in TOPICS
}
_HEADER_FIELDS: Final = shape_of(Header).read


def read_header(topic: Topic, data: bytes) -> Header | None:
    """Return the header of a message; ``None`` if the bytes are not a message of the topic in this schema version.

    The checksum is verified and the body is parsed, but its fields are neither copied nor validated: this takes about a
    tenth of the time of ``passafe_protocol.codec.decode``.
    """
    if not is_intact(data):
        return None
    try:
        message: Any = _MESSAGE_OF_TOPIC[topic.name].FromString(data)
    except ParseError:
        return None
    header = message.header
    if header.schema_version != SCHEMA_VERSION:
        return None
    return Header(*_HEADER_FIELDS(header))
