"""The way of a message out of a process."""

from time import monotonic_ns, time_ns

import pytest
from passafe_protocol.codec import decode
from passafe_protocol.errors import InvalidMessageError
from passafe_protocol.messages import Event, Header, OperatorCommand
from passafe_protocol.topics import COMMAND, EVENT, INPUT, Topic
from passafe_services.loop.bus import PublishBytes
from passafe_services.loop.errors import PublisherError
from passafe_services.loop.monotonic_clock import monotonic_clock_id
from passafe_services.loop.outlet import Outlet


class Wire:
    """Stands in for a bus and keeps what is put."""

    def __init__(self) -> None:
        self.put: dict[str, list[bytes]] = {}

    def publisher(self, topic: Topic, source: str) -> PublishBytes:
        """As ``Bus.publisher``."""
        assert source == "operator"
        return self.put.setdefault(topic.name, []).append


def command(value: float) -> OperatorCommand:
    return OperatorCommand((value,), (), enabled=True, device="constant")


@pytest.fixture
def wire() -> Wire:
    return Wire()


@pytest.fixture
def outlet(wire: Wire) -> Outlet:
    return Outlet(wire, "operator", epoch=42)


def test_headers_have_sender_times_and_number(wire: Wire, outlet: Outlet) -> None:
    before = (monotonic_ns(), time_ns())
    assert outlet.publish(COMMAND, command(1.0), scheduled_ns=3, started_ns=5) is None
    after = (monotonic_ns(), time_ns())
    header, body = decode(COMMAND, wire.put["command"][0])
    assert body == command(1.0)
    assert header == Header("operator", 42, 0, 3, 5, header.sent_ns, header.wall_ns, monotonic_clock_id())
    assert before[0] <= header.sent_ns <= after[0]
    assert before[1] <= header.wall_ns <= after[1]


def test_each_topic_counts_from_zero(wire: Wire, outlet: Outlet) -> None:
    for topic, body in ((COMMAND, command(1.0)), (EVENT, Event("info", "x")), (COMMAND, command(2.0))):
        outlet.publish(topic, body, scheduled_ns=0, started_ns=0)
    numbers = {name: [decode_number(name, data) for data in put] for name, put in wire.put.items() if put}
    assert numbers == {"command": [0, 1], "event": [0]}


def decode_number(name: str, data: bytes) -> int:
    return decode({"command": COMMAND, "event": EVENT}[name], data)[0].sequence


def test_invalid_messages_are_withheld_and_use_no_number(wire: Wire, outlet: Outlet) -> None:
    error = outlet.publish(COMMAND, command(float("nan")), scheduled_ns=0, started_ns=0)
    assert isinstance(error, InvalidMessageError)
    assert error.field.startswith("u_h")
    assert outlet.withheld == 1
    assert outlet.publish(COMMAND, command(0.0), scheduled_ns=0, started_ns=0) is None
    assert [decode(COMMAND, data)[0].sequence for data in wire.put["command"]] == [0]


def test_a_body_may_be_a_function(wire: Wire, outlet: Outlet) -> None:
    outlet.publish(COMMAND, lambda: command(3.0), scheduled_ns=0, started_ns=0)
    assert decode(COMMAND, wire.put["command"][0])[1] == command(3.0)


def test_process_publishes_only_its_topics(outlet: Outlet) -> None:
    with pytest.raises(PublisherError, match="publisher of input: got 'operator', allowed filter"):
        outlet.publish(INPUT, command(0.0), scheduled_ns=0, started_ns=0)
