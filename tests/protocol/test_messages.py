"""Tuples and ``passafe.proto`` name the same fields and values."""

import inspect
from enum import IntEnum

import pytest
from msgspec.structs import replace
from passafe_protocol import messages, passafe_pb2
from passafe_protocol.messages import FilterStatus, Header, PlantPhase
from passafe_protocol.shapes import shape_of

TUPLE_TYPES = [
    value
    for value in vars(messages).values()
    if inspect.isclass(value)
    and issubclass(value, messages.Record)
    and value not in {messages.Record, messages.Received}
]


@pytest.mark.parametrize("tuple_type", TUPLE_TYPES, ids=lambda tuple_type: tuple_type.__name__)
def test_fields_are_those_of_the_proto_file(tuple_type: type) -> None:
    in_proto = {field.name for field in getattr(passafe_pb2, tuple_type.__name__).DESCRIPTOR.fields}
    beside_the_body = {"schema_version"} if tuple_type is Header else {"header", "checksum"}

    assert set(shape_of(tuple_type).names) == in_proto - beside_the_body


def test_every_message_of_the_proto_file_has_a_tuple() -> None:
    assert {tuple_type.__name__ for tuple_type in TUPLE_TYPES} == set(passafe_pb2.DESCRIPTOR.message_types_by_name)


@pytest.mark.parametrize("enum", [PlantPhase, FilterStatus], ids=lambda enum: enum.__name__)
def test_enum_values_are_those_of_the_proto_file(enum: type[IntEnum]) -> None:
    in_proto = passafe_pb2.DESCRIPTOR.enum_types_by_name[enum.__name__].values

    assert {member.name: member.value for member in enum} == {v.name: v.number for v in in_proto if v.number}


def test_fallbacks_are_the_most_severe_statuses() -> None:
    by_severity = sorted(FilterStatus, key=lambda status: status.severity)
    assert by_severity[0] is FilterStatus.PASSED
    assert [status.severity for status in by_severity] == list(range(1, len(FilterStatus) + 1))
    first = next(k for k, status in enumerate(by_severity) if status.is_fallback)
    assert all(status.is_fallback for status in by_severity[first:])


def test_the_robot_is_where_the_plant_knows_it_to_be(body_of: dict[type[messages.Message], messages.Message]) -> None:
    state = body_of[messages.PlantState]
    assert isinstance(state, messages.PlantState)

    assert replace(state, true_x=()).actual_x == state.x
    assert replace(state, true_x=(9.0,) * len(state.x)).actual_x == (9.0,) * len(state.x)
