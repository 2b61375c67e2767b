"""Messages are decoded within a share of the period, whatever comes."""

from collections import deque
from collections.abc import Callable

from passafe_protocol.topics import COMMAND, STATE, STOP, Topic
from passafe_services.loop.bounded_reading import AT_ONCE, BoundedReading
from passafe_services.loop.inlet import Inlet


class Flooded:
    """Reader of a topic on which so many messages came since the last step, in a ring like that of the bus."""

    def __init__(self, topic: Topic, each: int) -> None:
        self.topic = topic
        self.each = each
        self.made = 0
        self.ring = deque[bytes](maxlen=topic.queue)
        self.on_drain: Callable[[int], object] = int

    def arrive(self) -> None:
        """Let the messages of one step arrive, numbered."""
        self.ring.extend(f"{self.topic.name} {k}".encode() for k in range(self.made, self.made + self.each))
        self.made += self.each

    def drain(self, at_most: int) -> list[bytes]:
        """Return the oldest messages."""
        taken = [self.ring.popleft() for _ in range(min(at_most, len(self.ring)))]
        self.on_drain(len(taken))
        return taken


class Clock:
    """A clock that a message takes forward, when it is taken from the bus and when it is decoded."""

    def __init__(self, cost_ns: int, drain_cost_ns: int = 0) -> None:
        self.now_ns = 0
        self.cost_ns = cost_ns
        self.drain_cost_ns = drain_cost_ns

    def __call__(self) -> int:
        """Return the time."""
        return self.now_ns

    def read(self, reading: BoundedReading, budget_ns: int) -> list[str]:
        """Return the messages of one step, each of which takes its cost."""
        for reader in readers_of(reading):
            reader.arrive()
            reader.on_drain = self._take
        reading.drain(self.now_ns + budget_ns, self)
        found = []
        for inlet, data in reading.messages(self.now_ns + budget_ns, self):
            assert data.decode().split()[0] == inlet.topic.name
            found.append(data.decode())
            self.now_ns += self.cost_ns
        return found

    def _take(self, taken: int) -> None:
        self.now_ns += taken * self.drain_cost_ns


def readers_of(reading: BoundedReading) -> list[Flooded]:
    return [reader for _, reader, _ in reading._sources if isinstance(reader, Flooded)]


def reading_of(**each: int) -> BoundedReading:
    topics: dict[str, Topic] = {topic.name: topic for topic in (STOP, COMMAND, STATE)}
    return BoundedReading([(Inlet(topics[name]), Flooded(topics[name], number)) for name, number in each.items()])


def test_without_a_flood_all_is_read_in_order_of_each_topic() -> None:
    assert Clock(1).read(reading_of(stop=0, command=3, state=1), 100) == [
        "command 0",
        "state 0",
        "command 1",
        "command 2",
    ]


def test_a_flood_takes_its_share_and_delays_others_by_one_each() -> None:
    reading, clock = reading_of(stop=1, command=5_000, state=1), Clock(10)
    for step in range(50):
        before_ns = clock.now_ns
        found = clock.read(reading, 500)
        assert clock.now_ns - before_ns <= 500 + 3 * 10
        assert found[:3:2] == [f"stop {step}", f"state {step}"]
        assert sum(name.startswith("command") for name in found) >= 48


def test_what_waits_is_bounded_and_the_oldest_goes_first() -> None:
    reading, clock = reading_of(command=1_000), Clock(10)
    for _ in range(20):
        clock.read(reading, 100)
    [(_, _, waiting)] = reading._sources
    assert len(waiting) <= COMMAND.queue
    assert clock.read(reading, 100)[0] == f"command {21_000 - COMMAND.queue}"


def test_one_message_of_each_topic_is_read_even_without_time() -> None:
    assert Clock(10).read(reading_of(stop=2, command=2), 0) == ["stop 0", "command 0"]


def test_a_flood_is_taken_from_the_bus_within_its_share() -> None:
    reading, clock = reading_of(stop=1, command=5_000, state=5_000), Clock(0, drain_cost_ns=10)
    for step in range(50):
        before_ns = clock.now_ns
        found = clock.read(reading, 500)
        assert clock.now_ns - before_ns <= 500 + (1 + 2 * AT_ONCE) * 10
        assert found[0] == f"stop {step}"
    for reader in readers_of(reading):
        assert len(reader.ring) == (0 if reader.topic is STOP else STATE.queue - 2 * AT_ONCE)
