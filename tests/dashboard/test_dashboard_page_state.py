import json
from math import inf
from typing import Any

import pytest
from closed_form import MS, ClosedFormRun, h, header, health, paper_scenario, state, tick
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.page_state import REPORTING, liveness, page_state
from passafe_dashboard.live.partial_decoding import decode_state_partially
from passafe_protocol.codec import encode
from passafe_protocol.messages import FilterStatus, OverrideReport, PlantPhase
from passafe_services.scenarios.schema import Scenario


def feed_after(run_ns: int) -> Feed:
    feed = Feed(paper_scenario())
    for message in ClosedFormRun().until(run_ns):
        feed.push(*message)
    return feed


def test_everything_the_page_shows_is_there() -> None:
    shown = page_state(feed_after(2_000 * MS), 2_000 * MS)
    assert shown["liveness"]["state"] == "live"
    assert shown["filter"]["tick"] == 1999
    assert shown["filter"]["status"] == "MODIFIED"
    assert shown["filter"]["barriers"] == [{"name": "disk", "psi": tick(1999).barriers[0].psi}]
    assert shown["filter"]["state_age_ms"] == pytest.approx(1.2)
    assert [row["active"] for row in shown["filter"]["rows"]] == [True, False]
    assert [row["share"] for row in shown["filter"]["rows"]] == [1.0, 0.0]
    assert shown["filter"]["override"] == {
        "held_back": (3.0, 4.0),
        "held_back_norm": 5.0,
        "allowed_fraction": 0.625,
        "unavoidable": False,
        "distance_to_infeasibility": 12.5,
    }
    assert shown["plant"]["h"][0]["value"] == pytest.approx(h(1.999))
    assert shown["plant"]["phase"] == "RUNNING"
    assert shown["worst"]["barriers"][0]["measured"]["value"] == pytest.approx(0.44, abs=1e-3)
    assert shown["worst"]["barriers"][0]["measured"]["at_s"] == pytest.approx(1.571, abs=1e-3)
    assert shown["scenario"]["mode"] == "both"
    assert shown["scenario"]["driver"] == "live"
    assert shown["links"] == [{"link": "plant-to-filter", "effect": "dropped", "count": 2}]
    assert [event["text"] for event in shown["events"]] == ["second 0", "second 1"]
    assert sum(shown["status_counts"].values()) == 2000
    assert json.loads(json_text(shown))["filter"]["tick"] == 1999


def test_the_verdict_so_far_is_that_of_a_review() -> None:
    feed = feed_after(2_000 * MS)
    assert page_state(feed, 0)["verdict"] == {"outcome": "holds", "words": "holds"}
    feed.push(header("filter", 2000), tick(2000, status=FilterStatus.AT_SAMPLES), 2_000 * MS)
    shown = page_state(feed, 0)["verdict"]
    assert shown["outcome"] == "fails"
    assert shown["words"] == (
        "fails: in a fallback in 1 of 2001 ticks (0.05%: AT_SAMPLES 1), first at 2.000 s, longest stretch 0.001 s"
    )


@pytest.mark.parametrize("is_partial", [False, True])
def test_noise_of_a_reading_takes_no_robot_out_of_its_set(*, is_partial: bool) -> None:
    feed = feed_after(2_000 * MS)
    noisy = state(2000, x=(0.999, 0.0, 0.0, 0.0), true_x=(1.001, 0.0, 0.0, 0.0))
    if is_partial:
        read = decode_state_partially(encode(header("plant", 2000), noisy))
        assert read is not None
        feed.push_partial(*read, 2_000 * MS)
    else:
        feed.push(header("plant", 2000), noisy, 2_000 * MS)
    shown = page_state(feed, 0)

    assert shown["worst"]["barriers"][0]["measured"]["value"] == pytest.approx(1.001**2 - 1)
    assert shown["verdict"]["outcome"] == "holds"


@pytest.mark.parametrize(("x", "outcome"), [(1.001, "holds"), (0.998, "unproven"), (0.98, "fails")])
def test_what_a_sensor_may_be_wrong_by_fails_no_run(x: float, outcome: str) -> None:
    content = paper_scenario().model_dump(mode="json", exclude_unset=True)
    content["uncertainty"] = {"state_error": {"position": 0.01}}
    content["plant"]["driver"] = {"kind": "udp-servo", "port": 4000}
    content["filter"]["mode"] = "safe"
    feed = Feed(Scenario.model_validate(content))
    feed.push(header("filter", 0), tick(0), 0)
    feed.push(header("plant", 0), state(0, x=(x, 0.0, 0.0, 0.0)), 0)

    shown = page_state(feed, 0)["verdict"]
    assert shown["outcome"] == outcome
    assert ("error of the states as read" in shown["words"]) == (outcome == "unproven")


def test_before_a_scenario_and_a_state_nothing_holds() -> None:
    assert page_state(Feed(), 0)["verdict"] is None
    assert page_state(Feed(paper_scenario()), 0)["verdict"]["outcome"] == "unproven"


def test_a_state_of_another_scenario_shows_no_h() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), state(0, x=(1.0,)), 0)
    assert page_state(feed, 0)["plant"]["h"] == []


def test_processes_and_topics_are_listed_in_table_order() -> None:
    shown = page_state(feed_after(2_000 * MS), 2_000 * MS)
    assert [process["process"] for process in shown["processes"]] == list(REPORTING)
    states = {process["process"]: process["state"] for process in shown["processes"]}
    assert states == dict.fromkeys(REPORTING, "ok") | {"dashboard": "no report"}
    topics = [(topic["topic"], topic["source"]) for topic in shown["topics"]]
    assert topics[:2] == [("state", "plant"), ("tick", "filter")]
    assert ("health", "router") in topics


def test_a_process_that_stopped_reporting_is_silent() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), health(1), 0)
    state_at = {
        now_ms: next(p["state"] for p in page_state(feed, now_ms * MS)["processes"] if p["process"] == "plant")
        for now_ms in (0, 2_999, 3_001)
    }
    assert state_at == {0: "ok", 2_999: "ok", 3_001: "silent"}


def test_empty_feed_has_null_values_and_waits() -> None:
    shown = page_state(Feed(), 0)
    assert shown["filter"] is None
    assert shown["plant"] is None
    assert shown["scenario"] is None
    assert shown["worst"] == {"barriers": [], "power_margin_w": None, "tank_j": None}
    assert shown["liveness"] == {"state": "waiting", "text": "No message from filter and plant yet."}


def test_waiting_names_the_missing_process() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), state(0), 0)
    assert liveness(feed, 0)["text"] == "No message from filter yet."


@pytest.mark.parametrize(
    ("now_ms", "expected"),
    [(1_999, "live"), (2_450, "live"), (2_550, "silent")],
)
def test_silence_is_reported_after_half_a_second(now_ms: int, expected: str) -> None:
    assert liveness(feed_after(2_000 * MS), now_ms * MS)["state"] == expected


def test_silence_names_the_silent_process() -> None:
    feed = feed_after(2_000 * MS)
    feed.push(header("plant", 2_000), state(2_000), 4_000 * MS)
    text = liveness(feed, 4_000 * MS)["text"]
    assert "filter for 2.0 s" in text
    assert "plant" not in text


def test_the_end_of_the_run_outranks_silence() -> None:
    feed = feed_after(2_000 * MS)
    feed.finish("The run has ended.")
    assert liveness(feed, 10_000 * MS) == {"state": "ended", "text": "The run has ended."}


def test_an_age_that_is_not_known_is_null() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0), tick(0, state_age_ns=-1, command_age_ns=-1), 0)
    shown = page_state(feed, 0)["filter"]
    assert shown["state_age_ms"] is None
    assert shown["command_age_ms"] is None
    assert shown["command_words"] == "not reported"


def test_unreported_override_is_null() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0), tick(0, override=OverrideReport()), 0)
    assert page_state(feed, 0)["filter"]["override"] is None


@pytest.mark.parametrize("status", list(FilterStatus))
def test_every_status_has_a_meaning(status: FilterStatus) -> None:
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0), tick(0, status=status), 0)
    shown = page_state(feed, 0)["filter"]
    assert shown["status"] == status.name
    assert len(shown["meaning"]) > 20


@pytest.mark.parametrize("phase", list(PlantPhase))
def test_every_phase_has_a_meaning(phase: PlantPhase) -> None:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), state(0, phase=phase), 0)
    assert page_state(feed, 0)["plant"]["meaning"]


def test_non_finite_numbers_become_null_in_json() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("plant", 0), state(0, x=(1e200, 0.0, 0.0, 0.0)), 0)
    shown = json.loads(json_text(page_state(feed, 0)))
    assert shown["plant"]["h"][0]["value"] is None
    assert shown["plant"]["x"][0] == 1e200
    assert json.loads(json_text({"a": [inf, (1.0, -inf)]})) == {"a": [None, [1.0, None]]}


@pytest.mark.parametrize(
    ("session", "text"),
    [
        ({"state": "starting"}, "Run 2 is starting."),
        ({"state": "stopping"}, "Run 2 is stopping."),
        ({"state": "stopped"}, "No run is going on: run 2 has ended. Start another one."),
        ({"state": "stopped", "trouble": "plant died"}, "No run is going on: plant died. Start another one."),
        ({"state": "running", "processes": {"filter": {"state": "down"}}}, "filter is down until restarted."),
        (
            {"state": "running", "processes": {name: {"state": "down"} for name in ("filter", "plant")}},
            "filter and plant are down until restarted.",
        ),
        ({"state": "running", "processes": {"filter": {"state": "running"}}}, "No message from filter and plant yet."),
    ],
)
def test_session_says_why_nothing_arrives(session: dict[str, Any], text: str) -> None:
    feed = Feed()
    feed.session = {"run": 2, "trouble": "", "processes": {}} | session

    assert liveness(feed, 0) == {"state": "waiting", "text": text}


def test_session_says_why_nothing_arrives_any_more() -> None:
    feed = feed_after(2_000 * MS)
    feed.session = {"state": "stopped", "run": 2, "trouble": "", "processes": {}}

    assert liveness(feed, 4_000 * MS)["text"] == "No run is going on: run 2 has ended. Start another one."
    assert liveness(feed, 2_000 * MS)["state"] == "live"
