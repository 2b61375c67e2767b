"""Every role against every topic: nothing arrives but what the topic table permits."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
import zenoh
from attackers import EVERYBODY, FORGED, WITNESS, Arena, arena, keys_of, own_key, wildcards_over
from passafe_protocol.identity import ROLES
from passafe_protocol.topics import READERS, TOPICS

pytestmark = pytest.mark.live

TARGET = "left"


@pytest.fixture(scope="module")
def field(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Arena]:
    with arena(tmp_path_factory.mktemp("field") / "keys") as made:
        yield made


every_role = pytest.mark.parametrize(("role", "robot"), EVERYBODY, ids=[f"{role}.{robot}" for role, robot in EVERYBODY])


def may(role: str, robot: str, publisher: str) -> bool:
    return robot == TARGET and role == publisher


def arrivals(field: Arena, role: str, robot: str, attack: list[tuple[str, bytes]]) -> list[tuple[str, bytes]]:
    """Return what arrives of some puts, and prove by a sentinel after them that nothing more is under way."""
    session, sentinel = field.session(role, robot), f"sentinel of {role}.{robot}".encode()
    marker = field.session("plant", robot)

    def send_mark(data: bytes) -> None:
        if role in READERS:  # it may send nothing: when it is answered, the router has handled what came before
            [*session.get(f"passafe/@admission/{role}.{robot}", timeout=5.0)]
            marker.put(own_key("plant", robot), data)
        else:
            session.put(own_key(role, robot), data)

    mark = field.session("plant", TARGET)
    theirs, own = field.watch(TARGET), field.watch(robot)
    try:
        own.ready(send_mark)
        theirs.ready(lambda data: mark.put(own_key("plant", TARGET), data))
        own.until(b"both are ready", send_mark)
        for key, payload in attack:
            session.put(key, payload)
        found = own.until(sentinel, send_mark)
        if robot != TARGET:  # the router has handled its messages; now one on the way to the target's recorder
            found += theirs.until(sentinel, lambda data: mark.put(own_key("plant", TARGET), data))
        return found
    finally:
        theirs.close()
        own.close()


@every_role
def test_a_role_publishes_its_rows_of_the_table_alone(field: Arena, role: str, robot: str) -> None:
    tried = [(key, f"{publisher} {key}".encode()) for topic in TOPICS for publisher, key in keys_of(topic, TARGET)]
    permitted = {key for topic in TOPICS for publisher, key in keys_of(topic, TARGET) if may(role, robot, publisher)}

    assert {key for key, _ in arrivals(field, role, robot, tried)} == permitted


@every_role
def test_nothing_arrives_under_a_wildcard(field: Arena, role: str, robot: str) -> None:
    keys = {wild for topic in TOPICS for _, key in keys_of(topic, TARGET) for wild in wildcards_over(key)}
    keys |= {f"{key}/@adv/**" for topic in TOPICS for _, key in keys_of(topic, TARGET)} - {
        f"{topic.key(role, robot)}/@adv/**" for topic in TOPICS
    }

    assert arrivals(field, role, robot, [(key, FORGED) for key in sorted(keys)]) == []


@every_role
def test_no_forged_heartbeat_of_a_cache_arrives(field: Arena, role: str, robot: str) -> None:
    suffixes = ("@adv/pub/0123/1/_/_", "@adv/sub/0123/1/_/_", "@adv/x", "@other", "more")
    tried = [
        (f"{key}/{suffix}", FORGED)
        for topic in TOPICS
        for publisher, key in keys_of(topic, TARGET)
        for suffix in suffixes
        if not may(role, robot, publisher)
    ]

    assert arrivals(field, role, robot, tried) == []


@every_role
def test_nothing_is_deleted(field: Arena, role: str, robot: str) -> None:
    session, watch, plant = field.session(role, robot), field.watch(TARGET), field.session("plant", TARGET)
    watch.ready(lambda data: plant.put(own_key("plant", TARGET), data))
    for topic in TOPICS:
        for _, key in keys_of(topic, TARGET):
            session.delete(key)
    session.delete("passafe/**")
    [*session.get("passafe/@admission/nobody", timeout=5.0)]  # the router has handled what came before
    try:
        assert watch.until(b"undeleted", lambda data: plant.put(own_key("plant", TARGET), data)) == []
    finally:
        watch.close()


@every_role
def test_no_question_reaches_a_publisher_but_the_recorders(field: Arena, role: str, robot: str) -> None:
    asked: list[str] = []

    def note(query: zenoh.Query) -> None:
        with query:
            asked.append(str(query.key_expr))
            query.reply(query.key_expr, b"the publisher's")

    with ExitStack() as stack:
        for topic in TOPICS:
            for publisher, key in keys_of(topic, TARGET):
                if publisher in ROLES:
                    for place in (key, f"{key}/@adv/pub/1/1/_/_"):
                        queryable = field.session(publisher, TARGET, WITNESS).declare_queryable(place, note)
                        stack.callback(queryable.undeclare)
        session = field.session(role, robot)
        questions = [f"{place}{more}" for more in ("", "/@adv/pub/1/1/_/_") for place in _keys()]
        for question in [*questions, "passafe/**", f"passafe/{TARGET}/*/*", f"passafe/{TARGET}/*/*/@adv/**"]:
            [*session.get(question, payload=FORGED, timeout=5.0)]

    if (role, robot) == ("recorder", TARGET):
        assert all("@adv" in key for key in asked)
        assert asked
    else:
        assert asked == []


@every_role
def test_no_forged_answer_reaches_the_recorder(field: Arena, role: str, robot: str) -> None:
    own = {topic.key(role, TARGET) for topic in TOPICS if robot == TARGET and role in topic.publishers}

    def forge(query: zenoh.Query) -> None:
        with query:
            for key in _keys():
                query.reply(key, key.encode())

    with ExitStack() as stack:
        session, recorder = field.session(role, robot), field.session("recorder", TARGET, WITNESS)
        for key in [*_keys(), f"passafe/{TARGET}/**", "passafe/**", "**"]:
            for place in (key, f"{key}/@adv/pub/0123/1/_/_"):
                stack.callback(session.declare_queryable(place, forge).undeclare)
        answers = [
            str(reply.ok.key_expr)
            for question in (f"passafe/{TARGET}/*/*/@adv/**", f"passafe/{TARGET}/*/*")
            for reply in recorder.get(
                question, timeout=5.0, target=zenoh.QueryTarget.ALL, accept_replies=zenoh.ReplyKeyExpr.ANY
            )
            if reply.ok is not None
        ]

    assert {*answers} <= own


def _keys() -> list[str]:
    return [key for topic in TOPICS for _, key in keys_of(topic, TARGET)]


@every_role
def test_a_robot_is_read_by_its_own_processes_alone(field: Arena, role: str, robot: str) -> None:
    session, plant = field.session(role, robot), field.session("plant", TARGET, WITNESS)
    wide = ("passafe/**", "**", f"passafe/{TARGET}/**", f"passafe/{TARGET}/*/*", f"passafe/{TARGET}/plant/state")
    readers = [session.declare_subscriber(key, zenoh.handlers.FifoChannel(1000)) for key in wide]
    watch = field.watch(TARGET)
    try:
        watch.ready(lambda data: plant.put(f"passafe/{TARGET}/plant/state", data))
        [*session.get(f"passafe/@admission/{role}.{robot}", timeout=5.0)]  # the router has sent what there was before
        got = {str(reader.key_expr) for reader in readers if reader.try_recv() is not None}
    finally:
        watch.close()
        for reader in readers:
            reader.undeclare()

    assert bool(got) == (robot == TARGET)
