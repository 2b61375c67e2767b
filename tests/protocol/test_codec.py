"""Round trips of messages, and what a log says of them to a stranger."""

from typing import Any

from any_message import MESSAGES, headers
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from passafe_protocol import passafe_pb2
from passafe_protocol.codec import decode, encode, file_descriptor_set, schema_name
from passafe_protocol.messages import (
    SCHEMA_VERSION,
    Certificate,
    FilterTick,
    Header,
    Message,
    OperatorCommand,
    OverrideReport,
    PlantState,
    RowReport,
)
from passafe_protocol.topics import COMMAND, TICK, TOPIC_OF_BODY, Topic
from refused_bytes import each_topic, examples, unchecked, wire


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
