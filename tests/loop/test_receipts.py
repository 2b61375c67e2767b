"""The wait of a process that ends, until the recorder has its last messages."""

import time

import pytest
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, Receipt, RecordedSession
from passafe_protocol.topics import EVENT, HEALTH, RECEIPT, Topic
from passafe_services.loop import receipts
from passafe_services.loop.bus import PublishBytes
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.receipts import Receipts

EPOCH = 42


class Bus:
    """Stands in for a bus on which the recorder says these things, one at each call; ``b""``: nothing."""

    def __init__(self, *said: bytes, then: bytes = b"") -> None:
        self.said = list(said)
        self.then = then

    def publisher(self, _topic: Topic, _source: str) -> PublishBytes:
        """As ``Bus.publisher``; what is published goes nowhere."""
        return lambda _data: None

    def reader(self, topic: Topic) -> "Bus":
        """As ``Bus.reader``."""
        assert topic is RECEIPT
        return self

    def drain(self) -> list[bytes]:
        """As ``TopicReader.drain``."""
        data = self.said.pop(0) if self.said else self.then
        return [data] if data else []


def receipt(newest: int, *, source: str = "plant", topic: str = "event", epoch: int = EPOCH) -> bytes:
    body = Receipt((RecordedSession("filter", "event", 1, 99), RecordedSession(source, topic, epoch, newest)))
    return encode(Header("recorder", 1, 0, 1, 2, 3, 4), body)


def missing(bus: Bus, events: int = 3) -> int:
    """Return what is still missing when a process with so many events has waited."""
    outlet = Outlet(bus, "plant", EPOCH)
    for k in range(events):
        outlet.publish(EVENT, Event("info", f"number {k}"), scheduled_ns=0, started_ns=0)
    return Receipts(bus).wait_for(outlet)


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(receipts, "WAIT_S", 0.3)
    monkeypatch.setattr(receipts, "SILENCE_S", 0.1)


def test_nobody_waits_for_a_recorder_that_never_reported() -> None:
    bus = Bus(b"", receipt(2))

    assert missing(bus) == 0
    assert bus.said == [receipt(2)]


def test_it_waits_until_the_last_message_is_recorded() -> None:
    bus = Bus(receipt(0), b"", receipt(1), b"damaged", receipt(2), receipt(3))

    assert missing(bus) == 0
    assert bus.said == [receipt(3)]


@pytest.mark.parametrize("other", [{"epoch": 41}, {"source": "router"}, {"topic": "health"}])
def test_what_another_session_has_sent_counts_for_nothing(other: dict[str, object]) -> None:
    assert missing(Bus(then=receipt(99, **other))) == 1  # type: ignore[arg-type]  # of the parameters above


def test_a_recorder_that_falls_silent_does_not_keep_it() -> None:
    begun_s = time.monotonic()

    assert missing(Bus(receipt(1))) == 1
    assert time.monotonic() - begun_s >= 0.1


def test_a_recorder_that_never_catches_up_does_not_keep_it() -> None:
    begun_s = time.monotonic()

    assert missing(Bus(then=receipt(1))) == 1
    assert time.monotonic() - begun_s >= 0.3


def test_what_was_not_published_is_not_waited_for() -> None:
    assert missing(Bus(receipt(0)), events=0) == 0


def test_an_outlet_knows_its_last_messages() -> None:
    outlet = Outlet(Bus(), "recorder", EPOCH)
    for topic, body in ((EVENT, Event("info", "one")), (EVENT, Event("info", "two")), (RECEIPT, Receipt(()))):
        outlet.publish(topic, body, scheduled_ns=0, started_ns=0)

    assert outlet.newest_recorded() == {"event": 1}
    assert HEALTH.recorded
    assert not RECEIPT.recorded
