from collections.abc import Callable

import pytest
from closed_form import MS, ClosedFormRun, header, paper_scenario, state, tick
from passafe_dashboard.live.bus_reader import BusReader
from passafe_dashboard.live.feed import Feed
from passafe_protocol.codec import encode
from passafe_protocol.messages import BarrierReport, Event, Health, Message
from passafe_protocol.topics import EVENT, HEALTH, STATE, TICK, TOPIC_OF_BODY, Topic
from passafe_services.loop.pace import Pace


class FakeReader:
    """Reader of the messages of a test."""

    def __init__(self) -> None:
        self.arrived: list[bytes] = []

    def drain(self) -> list[bytes]:
        """Return the messages of the test."""
        arrived, self.arrived = self.arrived, []
        return arrived


class FakeBus:
    """Readers that a test fills."""

    def __init__(self) -> None:
        self.readers: dict[str, FakeReader] = {}
        self.queues: set[int] = set()

    def reader(self, topic: Topic) -> FakeReader:
        """Return a separate reader for each topic."""
        self.queues.add(topic.queue)
        return self.readers.setdefault(topic.name, FakeReader())


class FakeOutlet:
    """Keeps what is published."""

    source = "dashboard"
    epoch = 1

    def __init__(self) -> None:
        self.published: list[Message] = []

    def publish(self, topic: Topic, body: Message | Callable[[], Message], **times: int) -> None:
        """As an outlet."""
        assert set(times) == {"scheduled_ns", "started_ns"}
        assert not callable(body)
        assert TOPIC_OF_BODY[type(body)] is topic
        self.published.append(body)


class Rig:
    """A reader between fakes."""

    def __init__(self) -> None:
        self.feed, self.bus, self.outlet = Feed(paper_scenario()), FakeBus(), FakeOutlet()
        self.reader = BusReader(self.bus, self.feed, self.outlet)  # type: ignore[arg-type] # stand-ins
        self.pace = Pace(0, 30.0)

    def arrive(self, topic: Topic, *messages: bytes) -> None:
        self.bus.readers[topic.name].arrived += messages

    def turn(self, now_ms: int) -> None:
        self.reader.read(now_ms * MS, self.pace)


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_feed_equals_one_with_every_message_fully_decoded(rig: Rig) -> None:
    whole = Feed(paper_scenario())
    for head, body, at_ns in ClosedFormRun().until(300 * MS):
        rig.arrive(TOPIC_OF_BODY[type(body)], encode(head, body))
        whole.push(head, body, at_ns)
    rig.turn(300)
    assert rig.feed.run.tick == whole.run.tick == tick(299)
    assert rig.feed.run.state == whole.run.state == state(299)
    assert rig.feed.run.worst == whole.run.worst
    assert rig.feed.run.ticks.since(0) == whole.run.ticks.since(0)
    assert rig.feed.run.states.since(0) == whole.run.states.since(0)
    assert rig.feed.health == whole.health


def test_queue_holds_four_seconds_of_ticks(rig: Rig) -> None:
    assert rig.bus.queues == {4096}


def test_a_dip_between_two_frames_is_seen(rig: Rig) -> None:
    for k in range(30):
        value = -0.5 if k == 11 else 1.0
        body = tick(k, barriers=(BarrierReport("disk", (value, value, value)),))
        rig.arrive(TICK, encode(header("filter", k), body))
    rig.turn(30)
    assert rig.feed.run.worst["psi_0_0"] == (-0.5, 0.011)


def test_undecodable_messages_are_counted_and_reported_once(rig: Rig) -> None:
    rig.arrive(TICK, b"\xff\xff", encode(header("filter", 0), tick(0)))
    rig.turn(0)
    rig.arrive(TICK, encode(header("filter", 1), tick(1)), b"\xff\xff\xff")
    rig.arrive(STATE, b"", encode(header("plant", 0), state(0)))
    rig.turn(1)
    assert rig.feed.refused == {"tick": 2, "state": 1}
    assert rig.feed.run.tick == tick(0)
    assert rig.feed.run.state == state(0)
    events = [body for body in rig.outlet.published if isinstance(body, Event)]
    assert [event.severity for event in events] == ["warning", "warning"]
    assert [event.text for event in rig.feed.events] == [event.text for event in events]


def test_health_is_published_once_a_second_and_shown(rig: Rig) -> None:
    for frame in range(91):
        now_ns = round(frame * 1e9 / 30)
        rig.pace.begin(now_ns)
        rig.reader.read(now_ns, rig.pace)
        rig.pace.end(now_ns)
    reports = [body for body in rig.outlet.published if isinstance(body, Health)]
    assert len(reports) == 3
    assert reports[-1].rate_hz == pytest.approx(30.0)
    assert reports[-1].steps == 90
    assert {topic.topic for topic in reports[-1].topics} >= {TICK.name, STATE.name, HEALTH.name, EVENT.name}
    assert rig.feed.processes["dashboard"].health == reports[-1]
