"""Scenario of a running system: an operator that joins takes it, or is refused; others say that theirs differs."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Event as Flag
from threading import Thread
from typing import Any

import pytest
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, ScenarioInfo
from passafe_protocol.topics import SCENARIO, Topic
from passafe_services.cli.errors import OptionError
from passafe_services.cli.joined_scenario import joined_scenario
from passafe_services.loop.bus import open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.routing import listening_router
from passafe_services.loop.running_scenario import running_scenario
from passafe_services.loop.shared_scenario import SharedScenario, digest
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario

HEAD = Header("filter", 1, 0, 0, 0, 0, 0)
SLOW = load_scenario("notomista-cai-2020", {"rate_hz": 250.0})
FAST = load_scenario("notomista-cai-2020", {"rate_hz": 500.0})


class Wire:
    """Bus on which waits what was put there."""

    def __init__(self, *waiting: bytes) -> None:
        self.waiting = list(waiting)
        self.readers = 0

    def reader(self, topic: Topic) -> "Wire":
        assert topic is SCENARIO
        self.readers += 1
        return self

    def drain(self) -> Sequence[bytes]:
        waiting, self.waiting = self.waiting, []
        return waiting


def info(scenario: Scenario) -> ScenarioInfo:
    return ScenarioInfo(scenario.model_dump_json(), "live", "{}")


def shared(process: str, scenario: Scenario, *waiting: bytes) -> SharedScenario:
    wire: Any = Wire(*waiting)
    return SharedScenario(process, scenario.model_dump_json(), wire)


def test_another_scenario_is_named_with_rates_and_digests() -> None:
    said = shared("plant", FAST, encode(HEAD, info(SLOW))).difference()

    assert said == (
        f"scenario digests differ: the filter's (250 Hz, digest {digest(SLOW.model_dump_json())}), the plant's "
        f"(500 Hz, digest {digest(FAST.model_dump_json())}): give all the same file"
    )


@pytest.mark.parametrize("waiting", [(), (encode(HEAD, info(FAST)),), (b"garbage",)])
def test_same_scenario_or_none_is_no_difference(waiting: tuple[bytes, ...]) -> None:
    assert shared("operator", FAST, *waiting).difference() == ""


def test_scenario_that_cannot_be_read_differs() -> None:
    odd = ScenarioInfo("[]", "live", "{}")

    assert "unknown rate" in shared("plant", FAST, encode(HEAD, odd)).difference()


def test_filter_repeats_what_it_published_and_compares_nothing() -> None:
    wire: Any = Wire(encode(HEAD, info(SLOW)))
    own = SharedScenario("filter", FAST.model_dump_json(), wire)
    own.keep(Event("info", "started"))
    assert own.repeated is None
    own.keep(info(FAST))

    assert own.repeated == info(FAST)
    assert own.difference() == ""
    assert wire.readers == 0


@contextmanager
def running_filter(endpoint: RouterEndpoint, *texts: str) -> Iterator[None]:
    """Publish a filter's scenario, as it repeats it, until the end of the block."""
    stop = Flag()

    def publish() -> None:
        with open_bus(endpoint) as bus:
            put = bus.publisher(SCENARIO, "filter")
            while not stop.wait(0.05):
                for text in texts:
                    put(encode(HEAD, ScenarioInfo(text, "live", "{}")))
                put(b"garbage")

    thread = Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@pytest.fixture
def endpoint(port: int) -> Iterator[RouterEndpoint]:
    place = RouterEndpoint(port=port)
    with listening_router(place):
        yield place


@pytest.mark.live
def test_operator_that_joins_takes_the_running_scenario(endpoint: RouterEndpoint) -> None:
    with running_filter(endpoint, SLOW.model_dump_json()):
        assert joined_scenario(FAST, endpoint, "robot", is_given=False) == SLOW
        assert joined_scenario(SLOW, endpoint, "robot", is_given=True) == SLOW
        with pytest.raises(
            OptionError, match=r"--scenario: got .*500 Hz, digest .*250 Hz, digest .*leave the option out"
        ):
            joined_scenario(FAST, endpoint, "robot", is_given=True)


@pytest.mark.live
def test_operator_without_a_filter_takes_its_own(endpoint: RouterEndpoint, capsys: pytest.CaptureFixture[str]) -> None:
    with open_bus(endpoint) as bus:
        assert running_scenario(bus, 0.1) is None
    assert joined_scenario(FAST, endpoint, "robot", is_given=True) == FAST
    assert capsys.readouterr().err == "no filter has named its scenario: taking notomista-cai-2020\n"


def test_digest_tells_scenarios_apart() -> None:
    assert len({digest(each.model_dump_json()) for each in (SLOW, FAST)}) == 2
    assert json.loads(SLOW.model_dump_json())["rate_hz"] == 250.0
