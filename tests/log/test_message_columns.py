"""Columns of any messages, beside what the codec says of each of them."""

from typing import Any

import numpy as np
import pytest
from any_message import MESSAGES, headers
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from passafe_protocol import codec
from passafe_protocol.checksum import CHECKSUM_BYTES, with_checksum
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import (
    Certificate,
    CommandState,
    Consumed,
    FilterStatus,
    FilterTick,
    Header,
    Message,
    PlantPhase,
    PlantState,
    RowReport,
)
from passafe_protocol.topics import STATE, TICK, TOPICS, Topic
from passafe_services.log.column import Ragged, Texts
from passafe_services.log.column_records import records_of
from passafe_services.log.message_columns import ColumnDecoder
from passafe_services.log.message_field import fields_of


def one_by_one(topic: Topic, messages: list[bytes]) -> dict[int, tuple[Header, Message]]:
    """Return what the codec makes of each message that it does not refuse."""
    found = {}
    for number, data in enumerate(messages):
        try:
            found[number] = codec.decode(topic, data)
        except ProtocolError:
            continue
    return found


def require_same_as_codec(topic: Topic, messages: list[bytes]) -> None:
    fields = fields_of(topic)
    table = ColumnDecoder(topic).decode(messages, fields)
    expected = one_by_one(topic, messages)
    assert table.valid.tolist() == list(expected)
    for path, field in fields.items():
        rows = [field.values(*message) for message in expected.values()]
        column: Any = table.columns[path]
        words: tuple[str, ...] = ()
        if isinstance(column, Texts):
            column, words = column.codes, column.words
        if isinstance(column, Ragged):
            assert column.counts.tolist() == [len(row) for row in rows], path
            column = column.values
        flat = [value for row in rows for value in row]
        assert [words[value] if words else value for value in column.tolist()] == flat, path
        if column.dtype.kind == "f":  # -0.0 as well
            assert column.tobytes() == np.array(flat, dtype=float).tobytes(), path


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_columns_are_what_the_codec_decodes(topic: Topic, data: st.DataObject) -> None:
    messages = []
    for _ in range(data.draw(st.integers(1, 3))):
        header, body = data.draw(headers), data.draw(MESSAGES[topic.body])
        alike = [codec.encode(replace(header, sequence=number), body) for number in range(data.draw(st.integers(1, 5)))]
        messages += alike
    bad = data.draw(st.integers(0, len(messages) - 1))
    at = data.draw(st.integers(0, len(messages[bad]) - CHECKSUM_BYTES - 1))
    changed = bytearray(messages[bad][:-CHECKSUM_BYTES])
    changed[at] = data.draw(st.integers(0, 255))
    messages[bad] = with_checksum(bytes(changed))

    require_same_as_codec(topic, data.draw(st.permutations(messages)))


def plant_state(number: int, **fields: object) -> PlantState:
    values: dict[str, Any] = {
        "plant_ns": number,
        "x": (0.5 * number, -0.0),
        "y": (1.0,),
        "u": (2.0,),
        "applied_tick": number,
        "phase": PlantPhase.RUNNING,
        "energy_in_j": float(number),
        "energy_stored_j": 0.0,
        "input_lead_ns": -number,
        "inputs_late": 0,
        "inputs_refused": 0,
        "integration_error": 0.25,
        "received_tick": 0,
    }
    return PlantState(**values | fields)


def encoded(number: int, body: Message) -> bytes:
    return codec.encode(Header("plant", 3, number, 1, 2, 3, 4), body)


@pytest.mark.parametrize(("field", "bad"), [("x_error", -0.375), ("residual", -1e-9)])
def test_a_vector_with_a_number_out_of_bounds_is_left_out(field: str, bad: float) -> None:
    bodies = [tick(k, rows=1, consumed=1, status=FilterStatus.MODIFIED) for k in range(6)]
    good = [encoded(k, replace(body, **{field: (0.375, 0.5)})) for k, body in enumerate(bodies)]
    changed = good[4][:-CHECKSUM_BYTES].replace(np.float64(0.375).tobytes(), np.float64(bad).tobytes())
    messages = [*good[:4], with_checksum(changed), good[5]]

    require_same_as_codec(TICK, messages)
    assert ColumnDecoder(TICK).decode(messages, [field]).valid.tolist() == [0, 1, 2, 3, 5]


def test_a_number_out_of_bounds_is_left_to_the_codec() -> None:
    good = [encoded(number, plant_state(number)) for number in range(6)]
    bad = [data[:-CHECKSUM_BYTES] for data in good]
    pairs = (
        (np.float64(0.25), np.float64(-0.25)),  # integration_error < 0
        (np.float64(2.0), np.float64("nan")),
        (np.float64(2.0), np.float64("inf")),
        (np.float64(2.0), np.float64(1e308)),  # huge and valid
    )
    for number, (before, after) in enumerate(pairs):
        changed = bad[number].replace(before.tobytes(), after.tobytes(), 1)
        assert changed != bad[number]
        good[number] = with_checksum(changed)

    require_same_as_codec(STATE, good)
    assert ColumnDecoder(STATE).decode(good, ()).valid.tolist() == [3, 4, 5]


def test_messages_that_are_no_messages_have_no_row() -> None:
    good = [encoded(number, plant_state(number)) for number in range(5)]
    unknown_field = with_checksum(good[0][:-CHECKSUM_BYTES] + b"\xf8\x07\x01")
    twice = with_checksum(good[1][:-CHECKSUM_BYTES] * 2)
    truncated = with_checksum(good[2][: len(good[2]) // 2])

    require_same_as_codec(STATE, [b"", b"x", *good, unknown_field, twice, truncated, good[3][:-1]])


def tick(number: int, *, rows: int, consumed: int, status: FilterStatus) -> FilterTick:
    return FilterTick(
        tick=number,
        status=status,
        mode="both",
        law="sampled",
        effective_plant_ns=number - 2,
        x_hat=(0.0, 1.0),
        u_h=(1.0,),
        u_h_rate=(),
        u_nominal=(1.0,),
        phi=(0.0,),
        v=(0.0,),
        u=(1.0,),
        barriers=(),
        power_margin=0.0,
        tank_j=1.0,
        slack=0.0,
        rows=tuple(RowReport(f"row {k}", float(k), float(k % 2), active=k % 2 == 1) for k in range(rows)),
        certificate=Certificate("piqp", accepted=True, primal_residual=-1.0, dual_residual=0.0, gap=0.0),
        consumed=tuple(Consumed("state", number * 100 + k, k, 7) for k in range(consumed)),
        state_age_ns=-1,
        command_age_ns=number,
        command_state=CommandState.COUNTS,
    )


def test_layouts_that_take_turns_come_back_in_order() -> None:
    statuses = (FilterStatus.PASSED, FilterStatus.MODIFIED)
    ticks = [tick(n, rows=n % 3, consumed=n % 4, status=statuses[n % 2]) for n in range(300)]
    messages = [encoded(number, body) for number, body in enumerate(ticks)]

    require_same_as_codec(TICK, messages)
    table = ColumnDecoder(TICK).decode(messages, ("rows.dual", "consumed.sequence", "rows.length"))
    duals = table.columns["rows.dual"]
    assert isinstance(duals, Ragged)
    assert duals.counts.tolist() == [n % 3 for n in range(300)]
    assert duals.matrix(2)[2].tolist() == [0.0, 1.0]


def test_known_layouts_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("passafe_services.log.message_columns.MOST_LAYOUTS", 2)
    decoder = ColumnDecoder(TICK)
    for status in FilterStatus:
        messages = [encoded(n, tick(n, rows=1, consumed=1, status=status)) for n in range(1, 9)]
        assert decoder.decode(messages, ()).valid.size == 8

    assert max(len(layouts) for layouts in decoder._known.values()) <= 2


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_records_of_columns_are_what_the_codec_decodes(topic: Topic, data: st.DataObject) -> None:
    messages = []
    for _ in range(data.draw(st.integers(1, 3))):
        header, body = data.draw(headers), data.draw(MESSAGES[topic.body])
        messages += [codec.encode(replace(header, sequence=number), body) for number in range(4)]

    found = records_of(topic, ColumnDecoder(topic).decode(messages, fields_of(topic)).columns)

    expected = [codec.decode(topic, data) for data in messages]
    assert list(map(repr, found)) == list(map(repr, expected))  # by repr: types, and the sign of a zero, as well
