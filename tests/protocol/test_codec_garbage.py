"""No bytes whatsoever raise anything but the errors of the protocol."""

import pytest
from any_message import MESSAGES, headers
from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import CHECKSUM_BYTES, with_checksum
from passafe_protocol.codec import decode, encode
from passafe_protocol.errors import DecodeError, InvalidMessageError, ProtocolError, SchemaVersionError
from passafe_protocol.messages import (
    SCHEMA_VERSION,
    Event,
    Header,
    Message,
    PlantState,
)
from passafe_protocol.topics import EVENT, HEALTH, STATE, TOPIC_OF_BODY, TOPICS, Topic
from refused_bytes import decodes_or_refuses, each_topic, examples, unchecked, wire


@each_topic
@examples
@given(data=st.binary(max_size=300))
def test_random_bytes(topic: Topic, data: bytes) -> None:
    decodes_or_refuses(topic, data)
    decodes_or_refuses(topic, with_checksum(data))


@each_topic
@examples
@given(data=st.data())
def test_mutated_message(topic: Topic, data: st.DataObject) -> None:
    mutant = bytearray(encode(data.draw(headers), data.draw(MESSAGES[topic.body]))[:-CHECKSUM_BYTES])
    edits = st.tuples(st.integers(0, len(mutant) - 1), st.integers(0, 4), st.binary(max_size=4))
    for at, length, replacement in data.draw(st.lists(edits, min_size=1, max_size=4)):
        mutant[at : at + length] = replacement

    decodes_or_refuses(topic, with_checksum(bytes(mutant)))


@each_topic
@examples
@given(data=st.data())
def test_header_followed_by_random_fields(topic: Topic, data: st.DataObject) -> None:
    message = getattr(passafe_pb2, topic.body.__name__)()
    message.header.schema_version = SCHEMA_VERSION
    message.header.source = "plant"

    decodes_or_refuses(topic, with_checksum(message.SerializeToString() + data.draw(st.binary(max_size=100))))


def test_every_truncation(header: Header, body: Message) -> None:
    topic, whole = TOPIC_OF_BODY[type(body)], encode(header, body)
    for size in range(len(whole)):
        decodes_or_refuses(topic, whole[:size])
        decodes_or_refuses(topic, with_checksum(whole[: size - CHECKSUM_BYTES]))


def test_truncation_within_a_field_is_no_message(header: Header, body_of: dict[type, Message]) -> None:
    whole = encode(header, body_of[PlantState])

    with pytest.raises(DecodeError) as caught:
        decode(STATE, with_checksum(whole[: -CHECKSUM_BYTES - 1]))

    assert (caught.value.topic, caught.value.size) == ("state", len(whole) - 1)


@each_topic
@pytest.mark.parametrize("data", [b"", b"\x10\x01"], ids=["empty", "without a header"])
def test_no_header_is_no_message(topic: Topic, data: bytes) -> None:
    with pytest.raises(DecodeError, match="no header") as caught:
        decode(topic, with_checksum(data))

    assert caught.value.topic == topic.name


def test_text_that_is_not_utf8_is_no_message(header: Header) -> None:
    data = with_checksum(encode(header, Event("info", "abc"))[:-CHECKSUM_BYTES].replace(b"abc", b"a\xffc"))

    with pytest.raises(DecodeError, match="event"):
        decode(EVENT, data)


def test_message_of_another_topic_is_refused(header: Header, body: Message) -> None:
    data = encode(header, body)
    for topic in TOPICS:
        if topic.body is not type(body):
            with pytest.raises(ProtocolError):
                decode(topic, data)


@pytest.mark.parametrize("version", [0, SCHEMA_VERSION + 1, 2**32 - 1])
def test_another_schema_version_is_refused(header: Header, body: Message, version: int) -> None:
    message = unchecked(header, body)
    message.header.schema_version = version
    topic = TOPIC_OF_BODY[type(body)]

    with pytest.raises(SchemaVersionError) as caught:
        decode(topic, wire(message))

    assert (caught.value.topic, caught.value.got, caught.value.allowed) == (topic.name, version, str(SCHEMA_VERSION))


@pytest.mark.parametrize("phase", [0, 5, -1, 2**31 - 1])
def test_unknown_enum_value_is_refused(header: Header, body_of: dict[type, Message], phase: int) -> None:
    message = unchecked(header, body_of[PlantState])
    message.phase = phase

    with pytest.raises(InvalidMessageError) as caught:
        decode(STATE, wire(message))

    assert (caught.value.field, caught.value.got) == ("phase", phase)
    assert "1 (WAITING)" in caught.value.allowed


def test_deeply_nested_garbage_is_no_message() -> None:
    with pytest.raises(DecodeError):
        decode(HEALTH, with_checksum(b"\x4b" * 100_000))  # group upon group, none of them closed
