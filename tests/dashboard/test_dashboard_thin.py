import pytest
from closed_form import header, state, tick
from passafe_dashboard.columns import ColumnLayout
from passafe_dashboard.thin import THIN_READERS, thin_state, thin_tick
from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import sealed
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import SCHEMA_VERSION, FilterTick, PlantState
from passafe_protocol.topics import STATE, TICK

LAYOUT = ColumnLayout(obstacles=(), levels=(3,))


def test_a_thin_tick_has_what_charts_need() -> None:
    data = encode(header("filter", 7, epoch=3, at_ns=5), tick(500))
    read, whole = thin_tick(data), decode(TICK, data)
    assert read is not None
    thin = read[1]
    assert isinstance(thin, FilterTick)
    assert isinstance(whole[1], FilterTick)
    assert LAYOUT.tick_values(thin) == LAYOUT.tick_values(whole[1]) is not None
    assert (thin.status, thin.effective_plant_ns) == (tick(500).status, 500_000_000)
    assert (read[0].source, read[0].epoch, read[0].sequence) == ("filter", 3, 7)


def test_a_thin_state_has_what_charts_need() -> None:
    data = encode(header("plant", 7, epoch=3, at_ns=5), state(500))
    read = thin_state(data)
    assert read is not None
    thin = read[1]
    assert isinstance(thin, PlantState)
    assert (thin.x, thin.plant_ns, thin.phase) == (state(500).x, 500_000_000, state(500).phase)
    assert (read[0].source, read[0].epoch, read[0].sequence) == ("plant", 3, 7)


@pytest.mark.parametrize("topic", [TICK, STATE])
@pytest.mark.parametrize("data", [b"", b"\xff\xff\xff", b"garbage"])
def test_bytes_that_are_no_message_are_left_to_the_codec(topic: object, data: bytes) -> None:
    name = TICK.name if topic is TICK else STATE.name
    assert THIN_READERS[name](data) is None


def test_another_schema_version_and_an_unknown_word_are_left_to_the_codec() -> None:
    for thin, kind, body in (
        (thin_tick, passafe_pb2.FilterTick, tick(1)),
        (thin_state, passafe_pb2.PlantState, state(1)),
    ):
        source = "filter" if kind is passafe_pb2.FilterTick else "plant"
        message = kind.FromString(encode(header(source, 0), body))
        message.ClearField("checksum")
        assert thin(sealed(message.SerializeToString())) is not None
        assert thin(message.SerializeToString()) is None
        message.header.schema_version = 99
        assert thin(sealed(message.SerializeToString())) is None
        message.header.schema_version = SCHEMA_VERSION
        message.ClearField("status" if kind is passafe_pb2.FilterTick else "phase")
        assert thin(sealed(message.SerializeToString())) is None
