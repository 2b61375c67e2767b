from passafe_protocol.codec import encode
from passafe_protocol.messages import Message, ScenarioInfo
from passafe_protocol.topics import TOPIC_OF_BODY, TOPICS, Topic
from passafe_services.bridge.bus_view import MOST_AT_ONCE, BusView
from passafe_services.scenarios.load import load_scenario
from small_log import header, state, tick


class FakeReader:
    def __init__(self) -> None:
        self.waiting: list[bytes] = []

    def drain(self) -> list[bytes]:
        found, self.waiting = self.waiting, []
        return found


class FakeBus:
    def __init__(self) -> None:
        self.readers = {topic.name: FakeReader() for topic in TOPICS}

    def reader(self, topic: Topic) -> FakeReader:
        return self.readers[topic.name]

    def arrive(self, source: str, k: int, body: Message) -> None:
        self.readers[TOPIC_OF_BODY[type(body)].name].waiting.append(encode(header(source, k), body))


def test_what_arrives_is_shown_by_name() -> None:
    bus = FakeBus()
    view = BusView(bus, load_scenario("notomista-cai-2020"))
    bus.arrive("filter", 1, tick(1))
    bus.arrive("plant", 1, state(1))

    shown = {one.topic.name: one.message for one in view.poll()}

    assert shown["/passafe/tick"].barrier_disk_psi_0 == 1.5
    assert shown["/tf"].transforms[0].translation.x == 1.0
    assert [*view.poll()] == []


def test_of_many_states_the_newest_are_shown() -> None:
    bus = FakeBus()
    view = BusView(bus, load_scenario("notomista-cai-2020"))
    for k in range(20):
        bus.arrive("plant", k, state(k))

    states = [one.message.x_1 for one in view.poll() if one.topic.name == "/passafe/state"]

    assert states == [20.0 - MOST_AT_ONCE + k for k in range(MOST_AT_ONCE)]


def test_the_scene_is_that_of_the_running_filter() -> None:
    bus = FakeBus()
    view = BusView(bus, load_scenario("notomista-cai-2020"))
    walls = load_scenario("walls-and-disks")
    for k, text in enumerate(("{}", walls.model_dump_json())):
        bus.arrive("filter", k, ScenarioInfo(text, "live", "{}"))
    [*view.poll()]
    bus.arrive("plant", 1, state(1))

    [barriers] = [one.message for one in view.poll() if one.topic.name == "/passafe/scene/barriers"]

    assert {one.id for one in barriers.entities} == {one.name for one in walls.barriers if one.outline is not None}


def test_what_does_not_decode_is_counted() -> None:
    bus = FakeBus()
    view = BusView(bus, load_scenario("notomista-cai-2020"))
    bus.readers["state"].waiting.append(b"nonsense")

    assert [*view.poll()] == []
    assert view.refused == 1
