"""Both ends refuse fields that are not what the protocol allows."""

from typing import Any

import pytest
from link_parameters import PARAMETERS
from msgspec.structs import replace
from passafe_protocol.checksum import with_checksum
from passafe_protocol.codec import MAX_MESSAGE_BYTES, decode, encode
from passafe_protocol.errors import DecodeError, InvalidMessageError
from passafe_protocol.messages import (
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
    PlantInput,
    PlantState,
    RowReport,
)
from passafe_protocol.topics import EVENT, TICK, TOPIC_OF_BODY
from refused_bytes import unchecked, wire

BAD: list[tuple[type, dict[str, Any], str]] = [
    (PlantState, {"x": (1.0, float("nan"))}, "x"),
    (PlantState, {"energy_in_j": float("inf")}, "energy_in_j"),
    (PlantState, {"u": ()}, "u"),
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
