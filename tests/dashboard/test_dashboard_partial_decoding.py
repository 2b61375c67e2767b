import pytest
from closed_form import header, state, tick
from passafe_dashboard.columns import ColumnLayout
from passafe_dashboard.live.partial_decoding import PARTIAL_DECODERS, decode_state_partially, decode_tick_partially
from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import with_checksum
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import SCHEMA_VERSION, FilterTick, PlantState
from passafe_protocol.topics import STATE, TICK

LAYOUT = ColumnLayout(barriers=(), levels=(3,))


def test_partial_tick_has_the_columns_of_charts() -> None:
    data = encode(header("filter", 7, epoch=3, at_ns=5), tick(500))
    read, whole = decode_tick_partially(data), decode(TICK, data)
    assert read is not None
    partial = read[1]
    assert isinstance(partial, FilterTick)
    assert isinstance(whole[1], FilterTick)
    assert LAYOUT.tick_values(partial) == LAYOUT.tick_values(whole[1]) is not None
    assert (partial.status, partial.effective_plant_ns) == (tick(500).status, 500_000_000)
    assert (read[0].source, read[0].epoch, read[0].sequence) == ("filter", 3, 7)


def test_partial_state_has_the_columns_of_charts() -> None:
    data = encode(header("plant", 7, epoch=3, at_ns=5), state(500))
    read = decode_state_partially(data)
    assert read is not None
    partial = read[1]
    assert isinstance(partial, PlantState)
    assert (partial.x, partial.plant_ns, partial.phase) == (state(500).x, 500_000_000, state(500).phase)
    assert (read[0].source, read[0].epoch, read[0].sequence) == ("plant", 3, 7)


@pytest.mark.parametrize("topic", [TICK, STATE])
@pytest.mark.parametrize("data", [b"", b"\xff\xff\xff", b"garbage"])
def test_undecodable_bytes_are_left_to_the_codec(topic: object, data: bytes) -> None:
    name = TICK.name if topic is TICK else STATE.name
    assert PARTIAL_DECODERS[name](data) is None


def test_invalid_messages_are_left_to_the_codec() -> None:
    for decode_partially, kind, body in (
        (decode_tick_partially, passafe_pb2.FilterTick, tick(1)),
        (decode_state_partially, passafe_pb2.PlantState, state(1)),
    ):
        source = "filter" if kind is passafe_pb2.FilterTick else "plant"
        message = kind.FromString(encode(header(source, 0), body))
        message.ClearField("checksum")
        assert decode_partially(with_checksum(message.SerializeToString())) is not None
        assert decode_partially(message.SerializeToString()) is None
        message.header.schema_version = 99
        assert decode_partially(with_checksum(message.SerializeToString())) is None
        message.header.schema_version = SCHEMA_VERSION
        message.ClearField("status" if kind is passafe_pb2.FilterTick else "phase")
        assert decode_partially(with_checksum(message.SerializeToString())) is None
