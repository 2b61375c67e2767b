"""Round trips, refusals, and that no bytes whatsoever raise anything but the errors of the protocol."""

from typing import Any

import pytest
from any_message import MESSAGES, headers
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message as ProtobufMessage
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from link_parameters import PARAMETERS
from msgspec.structs import replace
from passafe_protocol import codec, passafe_pb2
from passafe_protocol.checksum import CHECKSUM_BYTES, with_checksum
from passafe_protocol.codec import MAX_MESSAGE_BYTES, decode, encode, file_descriptor_set, schema_name
from passafe_protocol.errors import DecodeError, InvalidMessageError, ProtocolError, SchemaVersionError
from passafe_protocol.messages import (
    SCHEMA_VERSION,
    BarrierReport,
    Certificate,
    Consumed,
    Event,
    FilterTick,
    Header,
    LinkConfig,
    LinkEvent,
    LinkOutage,
    LinkState,
    Message,
    OperatorCommand,
    OverrideReport,
    PlantInput,
    PlantState,
    RowReport,
)
from passafe_protocol.topics import COMMAND, EVENT, HEALTH, STATE, TICK, TOPIC_OF_BODY, TOPICS, Topic

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


@each_topic
@examples
@given(data=st.data())
def test_round_trip_is_exact(topic: Topic, data: st.DataObject) -> None:
    header, body = data.draw(headers), data.draw(MESSAGES[topic.body])

    back = decode(topic, encode(header, body))

    assert back == (header, body)
    assert repr(back) == repr((header, body))  # types too, and the sign of zero


def test_bytes_are_ordinary_protobuf(header: Header, body_of: dict[type, Message]) -> None:
    message = passafe_pb2.PlantState.FromString(encode(header, body_of[PlantState]))

    assert message.header.schema_version == SCHEMA_VERSION
    assert message.header.source == "plant"
    assert message.header.wall_ns == 1_763_800_005_000_060_000
    assert list(message.x) == [1.0, 2.0, 3.0, 4.0]
    assert message.phase == passafe_pb2.RUNNING
    assert message.input_lead_ns == -4_000_000
    assert message.integration_error == 1e-12


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


BAD: list[tuple[type, dict[str, Any], str]] = [
    (PlantState, {"x": (1.0, float("nan"))}, "x"),
    (PlantState, {"energy_in_j": float("inf")}, "energy_in_j"),
    (PlantState, {"u": (1.0,)}, "u"),
    (FilterTick, {"rows": (RowReport("", 0.0, 0.0, active=True),)}, "rows[0].name"),
    (FilterTick, {"barriers": (BarrierReport("disk", (float("nan"),)),)}, "barriers[0].psi"),
    (LinkConfig, {"link": "filter-to-moon"}, "link"),
    (LinkConfig, {"parameters": replace(PARAMETERS, loss=1.5)}, "parameters.loss"),
    (LinkConfig, {"parameters": replace(PARAMETERS, delay_s=-0.1)}, "parameters.delay_s"),
    (LinkConfig, {"parameters": replace(PARAMETERS, distribution="gamma")}, "parameters.distribution"),
    (LinkConfig, {"parameters": replace(PARAMETERS, quantiles_s=(0.0, 11.0))}, "parameters.quantiles_s"),
    (LinkConfig, {"parameters": replace(PARAMETERS, queue=0)}, "parameters.queue"),
    (LinkConfig, {"parameters": replace(PARAMETERS, outages=(LinkOutage(0.0, 1e9),))}, "parameters.outages[0].end_s"),
    (LinkEvent, {"effect": "eaten"}, "effect"),
    (LinkEvent, {"cause": "hunger"}, "cause"),
    (LinkState, {"trigger": "never"}, "trigger"),
]


@pytest.mark.parametrize(("body_type", "changes", "field"), BAD)
def test_both_ends_refuse_what_a_field_may_not_hold(
    header: Header, body_of: dict[type, Any], body_type: type, changes: dict[str, Any], field: str
) -> None:
    body = replace(body_of[body_type], **changes)
    topic = TOPIC_OF_BODY[body_type]

    with pytest.raises(InvalidMessageError) as sent:
        encode(header, body)
    with pytest.raises(InvalidMessageError) as read:
        decode(topic, wire(unchecked(header, body)))

    assert (sent.value.topic, sent.value.field) == (read.value.topic, read.value.field) == (topic.name, field)


def test_both_ends_refuse_a_message_without_source(header: Header, body: Message) -> None:
    nobody = replace(header, source="")

    with pytest.raises(InvalidMessageError) as sent:
        encode(nobody, body)
    with pytest.raises(InvalidMessageError) as read:
        decode(TOPIC_OF_BODY[type(body)], wire(unchecked(nobody, body)))

    assert sent.value.field == read.value.field == "header.source"


@pytest.mark.parametrize(
    ("body_type", "changes", "field"),
    [
        (PlantInput, {"tick": -1}, "tick"),
        (PlantInput, {"tick": 2**64}, "tick"),
        (PlantInput, {"tick": 1.5}, "tick"),
        (PlantInput, {"effective_plant_ns": 2**63}, "effective_plant_ns"),
        (PlantInput, {"u": None}, "u"),
        (PlantInput, {"u": (1.0, "2")}, "u"),
        (PlantState, {"x": (10**400,)}, "x"),
        (PlantState, {"energy_in_j": 10**400}, "energy_in_j"),
        (OperatorCommand, {"device": "\ud800"}, "device"),
        (OperatorCommand, {"device": None}, "device"),
        (
            FilterTick,
            {"consumed": (Consumed("state", 0, 0, 1), Consumed("state", -1, 0, 1))},
            "consumed[1].sequence",
        ),
        (FilterTick, {"certificate": Certificate(None, True, 0.0, 0.0, 0.0)}, "certificate.solver"),
    ],
)
def test_what_protobuf_cannot_carry_is_refused_by_name(
    header: Header, body_of: dict[type, Any], body_type: type, changes: dict[str, Any], field: str
) -> None:
    with pytest.raises(InvalidMessageError) as caught:
        encode(header, replace(body_of[body_type], **changes))

    assert caught.value.field == field


@pytest.mark.parametrize(("field", "got"), [("epoch", -1), ("sequence", 2**64), ("sent_ns", 2**63), ("source", None)])
def test_header_that_protobuf_cannot_carry_is_refused_by_name(
    header: Header, body: Message, field: str, got: object
) -> None:
    with pytest.raises(InvalidMessageError) as caught:
        encode(replace(header, **{field: got}), body)

    assert (caught.value.field, caught.value.got) == (f"header.{field}", got)


@pytest.mark.parametrize("body", [None, (1, 2), RowReport("disk", 0.0, 0.0, active=True)])
def test_only_messages_of_the_table_are_encoded(header: Header, body: object) -> None:
    with pytest.raises(InvalidMessageError, match=type(body).__name__):
        encode(header, body)


def test_size_is_limited_at_both_ends(header: Header) -> None:
    fits = Event("info", "x" * (MAX_MESSAGE_BYTES - 100))
    too_long = Event("info", "x" * MAX_MESSAGE_BYTES)

    assert decode(EVENT, encode(header, fits)) == (header, fits)
    with pytest.raises(InvalidMessageError, match="bytes"):
        encode(header, too_long)
    with pytest.raises(DecodeError, match="more than"):
        decode(EVENT, wire(unchecked(header, too_long)))


def test_deeply_nested_garbage_is_no_message() -> None:
    with pytest.raises(DecodeError):
        decode(HEALTH, with_checksum(b"\x4b" * 100_000))  # group upon group, none of them closed


def test_field_that_the_message_does_not_have_is_refused(header: Header, body: Message) -> None:
    unknown = b"\xa2\x06\x03abc"  # field 100, three bytes

    with pytest.raises(InvalidMessageError) as caught:
        decode(TOPIC_OF_BODY[type(body)], with_checksum(encode(header, body) + unknown))

    assert (caught.value.field, caught.value.got) == (type(body).__name__, "field number 100")


def test_field_that_a_part_does_not_have_is_refused(header: Header, body_of: dict[type, Message]) -> None:
    message = unchecked(header, body_of[FilterTick])
    message.rows[1].MergeFromString(b"\x50\x01")  # field 10, an integer

    with pytest.raises(InvalidMessageError) as caught:
        decode(TICK, wire(message))

    assert (caught.value.field, caught.value.got) == ("RowReport", "field number 10")


@each_topic
def test_schema_name_is_the_full_name(topic: Topic) -> None:
    assert schema_name(topic) == f"passafe.v1.{topic.body.__name__}"


def test_descriptor_set_explains_a_log_to_a_stranger(header: Header, body: Message) -> None:
    descriptors = descriptor_pb2.FileDescriptorSet.FromString(file_descriptor_set())
    pool = descriptor_pool.DescriptorPool()
    for file in descriptors.file:
        pool.Add(file)
    stranger = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema_name(TOPIC_OF_BODY[type(body)])))

    message = stranger.FromString(encode(header, body))

    assert message.header.sequence == 300
    assert message.SerializeToString() == encode(header, body)


def test_absent_certificate_is_an_empty_one(header: Header, body_of: dict[type, Message]) -> None:
    message = unchecked(header, body_of[FilterTick])
    message.ClearField("certificate")

    _, tick = decode(TICK, wire(message))

    assert isinstance(tick, FilterTick)
    assert tick.certificate == Certificate("", accepted=False, primal_residual=0.0, dual_residual=0.0, gap=0.0)


def test_tick_without_override_report_is_decoded(header: Header, body_of: dict[type, Message]) -> None:
    message = unchecked(header, body_of[FilterTick])
    message.ClearField("override")
    for row in message.rows:
        row.ClearField("share")
        row.ClearField("relaxed")
    for barrier in message.barriers:
        barrier.ClearField("eps")

    _, tick = decode(TICK, wire(message))

    assert isinstance(tick, FilterTick)
    assert tick.override == OverrideReport((), allowed_fraction=0.0, unavoidable=False, distance_to_infeasibility=0.0)
    assert tick.rows == (RowReport("disk", 0.5, 0.0, active=False), RowReport("passivity", 0.0, 2.0, active=True))
    assert [barrier.eps for barrier in tick.barriers] == [0.0, 0.0]


def test_command_keeps_its_dead_man(header: Header, body_of: dict[type, Any]) -> None:
    released = replace(body_of[OperatorCommand], enabled=False)

    assert decode(COMMAND, encode(header, released))[1] == released
