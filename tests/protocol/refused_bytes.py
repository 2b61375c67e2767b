"""Messages that codecs decode or refuse, and nothing else."""

import pytest
from google.protobuf.message import Message as ProtobufMessage
from hypothesis import HealthCheck, settings
from passafe_protocol import codec, passafe_pb2
from passafe_protocol.checksum import with_checksum
from passafe_protocol.codec import decode, encode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import (
    SCHEMA_VERSION,
    Header,
    Message,
)
from passafe_protocol.topics import TOPICS, Topic

# Time limits of hypothesis would judge the machine and what else it is doing.
examples = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
each_topic = pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)


def unchecked(header: Header, body: Message) -> ProtobufMessage:
    """Encode a message without validation, like a faulty sender."""
    message = getattr(passafe_pb2, type(body).__name__)()
    message.header.schema_version = SCHEMA_VERSION
    codec._fill("test", codec.shape_of(Header), message.header, header, "")
    codec._fill("test", codec.shape_of(type(body)), message, body, "")
    return message


def wire(message: ProtobufMessage) -> bytes:
    """Its bytes with the right checksum."""
    return with_checksum(message.SerializeToString())


def decodes_or_refuses(topic: Topic, data: bytes) -> None:
    """Check that bytes raise a typed error or give a message that can be sent on."""
    try:
        header, body = decode(topic, data)
    except ProtocolError:
        return
    assert decode(topic, encode(header, body)) == (header, body)
