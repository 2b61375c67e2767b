"""Ages by content, from a feed with messages of known ages."""

import pytest
from closed_form import MS, header, paper_scenario, state, tick
from msgspec.structs import replace
from passafe_dashboard.live.ages import ages
from passafe_dashboard.live.feed import Feed
from passafe_protocol.messages import FilterTick, PlantState

UNKNOWN = dict.fromkeys(("state_ms", "from_robot_ms", "to_robot_ms", "round_trip_ms", "command_ms"))


def fed(*, number: int = 300, received_tick: int = 200, state_age_ms: int = 250, command_age_ms: int = 40) -> Feed:
    feed = Feed(paper_scenario())
    body = replace(tick(0), tick=number, state_age_ns=state_age_ms * MS, command_age_ns=command_age_ms * MS)
    assert isinstance(body, FilterTick)
    feed.push(header("filter", 0), body, 5_000 * MS)
    at_rest = replace(state(0), received_tick=received_tick)
    assert isinstance(at_rest, PlantState)
    feed.push(header("plant", 0), at_rest, 5_000 * MS)
    return feed


def test_nothing_is_known_of_an_empty_feed() -> None:
    assert ages(Feed(), 0) == UNKNOWN
    assert ages(Feed(paper_scenario()), 0) == UNKNOWN


def test_ages_include_the_way_and_grow_while_nothing_comes() -> None:
    found = ages(fed(), 5_030 * MS)
    assert found["from_robot_ms"] == pytest.approx(250.0)
    assert found["state_ms"] == pytest.approx(280.0)
    assert found["to_robot_ms"] == pytest.approx(100.0)  # 100 ticks at 1 kHz
    assert found["round_trip_ms"] == pytest.approx(350.0)
    assert found["command_ms"] == pytest.approx(40.0)


def test_what_never_came_has_no_age() -> None:
    unseen = Feed(paper_scenario())
    body = replace(tick(0), state_age_ns=-1, command_age_ns=-1)
    unseen.push(header("filter", 0), body, 0)
    assert ages(unseen, MS) == UNKNOWN
    assert ages(fed(received_tick=0), 5_000 * MS)["to_robot_ms"] is None


def test_a_tick_that_is_not_read_yet_counts_as_no_delay() -> None:
    assert ages(fed(received_tick=310), 5_000 * MS)["to_robot_ms"] == 0.0


def test_an_input_of_an_ended_filter_has_no_age() -> None:
    found = ages(fed(received_tick=9_000), 5_000 * MS)
    assert found["to_robot_ms"] is found["round_trip_ms"] is None
