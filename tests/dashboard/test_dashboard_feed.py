from math import inf, nan

import pytest
from closed_form import MS, ClosedFormRun, h, header, health, paper_scenario, power_margin, state, tick
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs
from passafe_dashboard.live.feed import Feed, scenario_id
from passafe_protocol.messages import (
    BarrierReport,
    Event,
    FilterStatus,
    LinkEvent,
    OperatorCommand,
    PlantInput,
    ScenarioInfo,
    TopicHealth,
)
from passafe_protocol.topics import TICK


def run_of(seconds: float) -> Feed:
    feed = Feed(paper_scenario())
    for message in ClosedFormRun().until(round(seconds * 1e9)):
        feed.push(*message)
    return feed


def chain(value: float) -> tuple[BarrierReport, ...]:
    return (BarrierReport("disk", (value, value, value)),)


def test_a_run_leaves_its_newest_state_and_its_worst_values() -> None:
    feed = run_of(5.0)
    assert feed.run.tick == tick(4999)
    assert feed.run.state == state(4999)
    worst = feed.run.worst["psi_0_0"]
    assert worst.value == pytest.approx(min(h(k * 1e-3) for k in range(5000)))
    assert worst.value == pytest.approx(h(worst.at_s))
    assert feed.run.worst["h_0"].value == pytest.approx(worst.value)
    assert feed.run.worst["power_margin_w"].value == min(power_margin(k * 1e-3) for k in range(5000))
    assert feed.run.status_counts[FilterStatus.MODIFIED] == 3141
    assert feed.run.status_counts[FilterStatus.PASSED] == 5000 - 3141
    assert feed.health[0].received == 5000


@given(
    st.lists(st.floats(-10, 10), min_size=1, max_size=300),
    st.lists(st.floats(-10, 10), min_size=1, max_size=300),
)
def test_no_dip_of_a_barrier_or_the_power_margin_is_hidden(barrier: list[float], margin: list[float]) -> None:
    feed = Feed(paper_scenario())
    count = min(len(barrier), len(margin))
    for k in range(count):
        body = tick(k, barriers=chain(barrier[k]), power_margin=margin[k])
        feed.push(header("filter", k), body, k * MS)
    far = tick(100_000, barriers=chain(100.0), power_margin=100.0)
    feed.push(header("filter", count), far, count * MS)
    rows = feed.run.ticks.since(0).rows
    for column, expected in (("psi_0_0", barrier), ("psi_0_2", barrier), ("power_margin_w", margin)):
        index = feed.run.ticks.columns.index(column)
        shown = [row.values[index] for row in rows]
        assert min(value for value in shown if value is not None) == min(expected[:count])
        assert feed.run.worst[column].value == min(expected[:count])


def test_the_worst_status_of_a_bin_is_kept() -> None:
    feed = Feed(paper_scenario())
    for k in range(100):
        status = {40: FilterStatus.INFEASIBLE, 41: FilterStatus.STALE, 42: FilterStatus.BACKUP}.get(
            k, FilterStatus.PASSED
        )
        feed.push(header("filter", k), tick(k, status=status), k * MS)
    index = feed.run.ticks.columns.index("status")
    assert [row.values[index] for row in feed.run.ticks.since(0).rows] == [
        FilterStatus.PASSED.severity,
        FilterStatus.INFEASIBLE.severity,
    ]


def test_reordered_tick_counts_but_is_not_the_newest() -> None:
    feed = Feed(paper_scenario())
    for k in (0, 1, 3, 2):
        value = -1.0 if k == 2 else 1.0
        feed.push(header("filter", k), tick(k, barriers=chain(value)), k * MS)
    assert feed.run.tick is not None
    assert feed.run.tick.tick == 3
    assert feed.run.worst["psi_0_0"].value == -1.0


def test_repeated_messages_count_once() -> None:
    feed = Feed(paper_scenario())
    for _ in range(3):
        feed.push(header("filter", 0), tick(0), 0)
    assert feed.run.status_counts[FilterStatus.PASSED] == 1
    assert feed.topic_monitors["filter", "tick"].refused == 2


def test_a_restarted_plant_begins_a_new_run() -> None:
    feed = run_of(1.0)
    before = feed.run.number
    feed.push(header("plant", 0, epoch=2), state(0), 2000 * MS)
    assert feed.run.number == before + 1
    assert feed.run.ticks.since(0).rows == ()
    assert sum(feed.run.status_counts.values()) == 0
    assert set(feed.run.worst) == {"h_0"}
    assert feed.run.tick is None


def test_restarted_filter_continues_the_run() -> None:
    feed = run_of(1.0)
    run, rows, worst = feed.run.number, feed.run.ticks.since(0).rows, feed.run.worst
    again = structs.replace(tick(3000), tick=1)
    feed.push(header("filter", 0, epoch=2), again, 3000 * MS)
    assert feed.run.number == run
    assert feed.run.tick == again  # though the one before had a greater number
    assert feed.run.ticks.since(0).rows[: len(rows)] == rows
    assert feed.run.status_counts[FilterStatus.PASSED] + feed.run.status_counts[FilterStatus.MODIFIED] == 1001
    assert feed.run.worst.keys() == worst.keys()


def test_a_message_of_an_ended_session_changes_nothing() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0, epoch=2), tick(5), 0)
    feed.push(header("filter", 1, epoch=1), tick(9, barriers=chain(-5.0)), 0)
    assert feed.run.tick == tick(5)
    assert feed.run.worst["psi_0_0"].value == h(0.005)


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_non_finite_values_are_counted_and_not_drawn(value: float) -> None:
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0), tick(0, power_margin=value), 0)
    feed.push(header("plant", 0), state(0, x=(value, 0.0, 0.0, 0.0)), 0)
    feed.push(header("filter", 1), tick(1, barriers=()), 0)
    assert feed.run.mismatched == 3
    assert feed.run.worst == {}


def test_source_that_may_not_publish_a_topic_is_refused() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("operator", 0), tick(0), 0)
    assert feed.run.tick is None
    assert feed.topic_monitors == {}
    assert feed.health[0] == TopicHealth("tick", 0, 0, 1)


def test_other_topics_are_ignored() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("operator", 0), OperatorCommand((0.0,), (), True, "lag"), 0)
    feed.push(header("filter", 0), PlantInput(0, (0.0,), 0, 0), 0)
    assert feed.topic_monitors == {}


def test_health_events_and_link_effects_are_kept() -> None:
    feed = Feed(paper_scenario(), events_kept=2)
    feed.push(header("plant", 0), health(7), 5)
    for k, text in enumerate("abc"):
        feed.push(header("filter", k), Event("warning", text), k)
        feed.push(header("plant", k), LinkEvent("filter-to-plant", "dropped", "input", k), k)
    assert feed.processes["plant"] == (health(7), 5)
    assert [(event.number, event.text) for event in feed.events] == [(1, "b"), (2, "c")]
    assert feed.run.link_effects == {("filter-to-plant", "dropped"): 3}


def test_announced_scenario_replaces_the_initial_one() -> None:
    feed = Feed()
    assert feed.scenario_id == "none"
    scenario = paper_scenario()
    feed.push(header("filter", 0), ScenarioInfo(scenario.model_dump_json(), "live", "{}"), 0)
    assert feed.scenario == scenario
    assert feed.layout.names == ("disk",)
    assert feed.scenario_id == scenario_id(scenario)
    run = feed.run.number
    feed.push(header("filter", 1), ScenarioInfo(scenario.model_dump_json(), "live", "{}"), 0)
    assert feed.run.number == run


def test_invalid_scenario_is_reported_as_an_event() -> None:
    feed = Feed(paper_scenario())
    feed.push(header("filter", 0), ScenarioInfo('{"name": 1}', "live", "{}"), 0)
    assert feed.scenario == paper_scenario()
    assert feed.events[-1].severity == "error"


def test_refused_messages_are_counted_by_topic() -> None:
    feed = Feed()
    feed.refuse(TICK)
    feed.refuse(TICK)
    assert feed.refused == {"tick": 2}


def test_history_is_bounded_in_time() -> None:
    feed = Feed(paper_scenario(), frame_hz=10, history_s=2.0)
    for message in ClosedFormRun().until(5_000_000_000):
        feed.push(*message)
    assert feed.capacity == 20
    assert len(feed.run.ticks.since(0).rows) == 20
