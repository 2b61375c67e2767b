from typing import Any

import pytest
from closed_form import MS, header, paper_scenario, state, tick
from passafe_dashboard.live.driver_words import DriverWords
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.page_state import page_state
from passafe_protocol.messages import CommandState, FilterStatus, GuardAction, OverrideReport, PlantPhase, RowReport

AT = (1.04, 0.0, 0.0, 0.0)
"""4 cm to the right of the disk."""

COUNTS = {"command_state": CommandState.COUNTS, "command_share": 1.0}
FREE = OverrideReport((0.0, 0.0), allowed_fraction=1.0, unavoidable=False, distance_to_infeasibility=10.0)


def words(of_tick: dict[str, Any], of_state: dict[str, Any] | None = None, *, later_ms: int = 0) -> DriverWords:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), state(0, **({"x": AT} | (of_state or {}))), 0)
    feed.push(header("filter", 0), tick(0, **({"x_hat": AT} | COUNTS | of_tick)), 0)
    return DriverWords(**page_state(feed, later_ms * MS)["words"])


def test_what_holds_back_is_named_with_side_and_distance() -> None:
    said = words({"u_h": (-3.0, 0.0)})
    assert said.tone == "held"
    assert said.headline == "Held back by “disk” on the left, 4.0 cm away"
    assert said.detail == "62 % of the command would pass unchanged."


def test_an_operator_who_asks_for_nothing_is_not_held_back() -> None:
    said = words({"u_h": (0.0, 0.0)})
    assert said.headline == "Kept off by “disk” on the left, 4.0 cm away"
    assert said.detail == "Nothing of yours is held back: the robot's own controller is."


def test_passivity_is_called_the_energy_balance() -> None:
    rows = (RowReport("passivity", 0.0, 0.4, True, 1.0), RowReport("disk", 1.0, 0.0, False))
    assert words({"rows": rows}).headline == "Held back by the energy balance"


def test_a_violated_barrier_wins_over_the_status() -> None:
    said = words({"status": FilterStatus.PASSED, "mode": "off"}, {"x": (0.76, 0.0, 0.0, 0.0)})
    assert said.tone == "broken"
    assert said.headline == "Beyond “disk” on the left by 24 cm"
    assert said.detail == "The mode asks for no safety."


@pytest.mark.parametrize(
    ("of_tick", "of_state", "headline", "detail"),
    [
        ({}, {"stop": 7, "stop_source": "dashboard"}, "Emergency stop", "Pressed at dashboard"),
        (
            {"status": FilterStatus.STALE, "command_state": CommandState.SILENT},
            {"phase": PlantPhase.FAIL_SAFE},
            "The robot brakes by itself",
            "No newer command",
        ),
        (
            {"override": FREE},
            {"guard": GuardAction.CHANGED, "guard_cause": "disk[mass=0.8]"},
            "The guard at the robot holds back: “disk” on the left, 4.0 cm away",
            "on the robot's own state",
        ),
        ({}, {"guard": GuardAction.FAIL_SAFE, "guard_cause": "fallback"}, "The guard at the robot brakes", "No input"),
        ({"override": FREE}, {"guard": GuardAction.PASSED}, "The way is free", "“disk” on the left"),
        ({"status": FilterStatus.STALE, "state_age_ns": 480 * MS}, {}, "Standing by", "480 ms old"),
        ({"status": FilterStatus.INFEASIBLE}, {}, "Limits conflict", "“disk” on the left, 4.0 cm away"),
        ({"override": FREE}, {}, "The way is free", "“disk” on the left, 4.0 cm away"),
        ({"override": FREE, "mode": "off"}, {}, "The filter is off", "Nothing is held back"),
        ({"override": FREE, "command_state": CommandState.RELEASED}, {}, "Nobody steers", "let go"),
        ({"override": FREE, "status": FilterStatus.RELAXED, "slack": 0.0127}, {}, "Passivity gives way by 0.013 W", ""),
    ],
)
def test_words_for_a_situation(of_tick: dict[str, Any], of_state: dict[str, Any], headline: str, detail: str) -> None:
    said = words(of_tick, of_state)
    assert said.headline.startswith(headline)
    assert detail in said.detail


def test_the_way_is_not_free_where_the_robot_touches() -> None:
    beside = {"x": (1.0005, 0.0, 0.0, 0.0)}
    said = words({"override": FREE, "x_hat": beside["x"]}, beside)

    assert said.headline == "Nothing is held back"
    assert said.detail == "Nearest: “disk” on the left, touching it."


def test_silence_is_said_before_anything_that_was_so() -> None:
    said = words({}, later_ms=1_200)
    assert said.headline == "Nothing new arrives"
    assert "filter for 1.2 s" in said.detail


def test_nothing_is_known_before_the_first_message() -> None:
    shown = page_state(Feed(paper_scenario()), 0)
    assert shown["words"]["headline"] == "Waiting for the robot"
    assert shown["gaps"] == shown["held"] == []
    assert shown["energy"] is None
