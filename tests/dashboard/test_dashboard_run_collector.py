"""The record of a run, made in a pass over its log."""

import json
from pathlib import Path

import numpy as np
import pytest
from closed_form import MS, header, paper_scenario, state
from closed_form import h as h_at
from closed_form_log import circle_record, record_of, write_log
from passafe_dashboard.run_record.chart_plan import chart_plans
from passafe_dashboard.run_record.collector import DETAIL, NUMBERS, RunCollector
from passafe_dashboard.run_record.detail_blocks import DetailBlock
from passafe_dashboard.run_record.run_payload import run_events, run_payload
from passafe_protocol.messages import LinkParameters, LinkState
from passafe_services.log.log_pass import LogSlice


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> RunCollector:
    return circle_record(tmp_path_factory.mktemp("log"))


def test_barriers_are_recomputed_from_every_state(record: RunCollector) -> None:
    times = np.arange(2_000) * 1e-3
    expected = np.array([h_at(t) for t in times])
    column = record.states.envelopes.index("h_0")
    assert record.states.low[column] == pytest.approx(expected, abs=1e-12)
    lowest = record.states.least("h_0")
    assert lowest is not None
    assert lowest.value == pytest.approx(0.44, abs=1e-6)
    assert lowest.at_ns == pytest.approx(1_571 * MS, abs=MS)


def test_barriers_are_those_of_the_robot_not_of_its_readings(tmp_path: Path) -> None:
    read = [(header("plant", k), state(k, x=(0.9, 0.0, 0.0, 0.0), true_x=state(k).x)) for k in range(100)]
    lowest = record_of(write_log(tmp_path / "noise.mcap", read)).states.least("h_0")

    assert lowest is not None
    assert lowest.value == pytest.approx(h_at(0.099))


def test_residual_is_that_of_the_exact_model(record: RunCollector) -> None:
    # x₂ = 0 in every state, so the model moves by the input alone: far from the circle.
    greatest = record.states.greatest("residual")
    assert greatest is not None
    assert 1e-4 < greatest.value < 1e-2
    assert np.isnan(record.states.low[record.states.envelopes.index("residual"), 0])


def test_signals_of_ticks_are_in_their_units(record: RunCollector) -> None:
    def first(name: str) -> float:
        return float(record.ticks.low[record.ticks.envelopes.index(name), 500])

    assert first("state_age_ms") == pytest.approx(1.2)
    assert first("command_age_ms") == pytest.approx(2)
    assert first("allowed") == 0.625
    assert first("held_back") == pytest.approx(5)
    assert (first("active_0"), first("active_1")) == (1, 0)
    assert (first("asked_0"), first("sent_1")) == (-1, 0.25)
    assert first("psi_0_2") == pytest.approx(100 * h_at(0.5))


def test_events_and_what_the_review_finds_are_in_order(record: RunCollector) -> None:
    events = run_events(record)
    assert [event.at_s for event in events] == sorted(event.at_s for event in events)
    texts = [event.text for event in events]
    assert "no input: <b>fail-safe</b>" in texts
    assert "plant in its fail-safe for 0.009 s" in texts
    warning = next(event for event in events if event.text.startswith("no input"))
    assert warning.at_s == pytest.approx(0.2, abs=1e-6)


def test_link_effects_are_counted(record: RunCollector) -> None:
    assert record.counts.counts("plant-to-filter: dropped").sum() == 2
    assert record.counts.per_s("ticks")[1:-1] == pytest.approx(1000)


def test_charts_are_those_for_which_there_are_signals(record: RunCollector) -> None:
    keys = [plan.key for plan in chart_plans(record, live=False)]
    assert keys == [
        "status", "h", "psi", "power", "energy", "input-0", "active", "override", "ages", "rates", "links", "residual",
    ]  # fmt: skip
    assert "latency" in [plan.key for plan in chart_plans(record, live=True)]
    rows = next(plan for plan in chart_plans(record, live=False) if plan.key == "active")
    assert [line.label for line in rows.lines] == ["disk"]


def test_settings_of_a_link_are_an_event(tmp_path: Path) -> None:
    blank = LinkParameters(0.25, 0.05, "normal", (), 0.0, True, 0.1, 0, 1, 0, 1, 0.0, 0.0, 0.0, 100, (), 1)
    counts = dict.fromkeys(
        ("entered", "delivered", "dropped_loss", "dropped_queue", "dropped_outage", "duplicated", "corrupted",
         "in_flight", "refused_corrupted", "refused_duplicate", "config_epoch", "config_sequence"), 0
    )  # fmt: skip
    link = LinkState(
        "plant-to-filter", "state", blank, 0, trigger="start", config_source="", refusal="", sources=(), **counts
    )
    path = write_log(tmp_path / "link.mcap", [(header("plant", 0), state(0)), (header("filter", 0), link)])
    (event,) = run_events(record_of(path))
    assert event.text == "link plant-to-filter: delay 250 ms ± 50 ms, loss 10 %"


def test_states_of_another_length_are_left_out(tmp_path: Path) -> None:
    path = write_log(tmp_path / "odd.mcap", [(header("plant", 0), state(0, x=(1.0, 2.0, 3.0)))])
    record = record_of(path)
    assert record.states.count.size == 0
    assert run_payload(record, label="odd")["end_s"] == 1.0


def test_an_hour_of_noise_stays_under_5_mb() -> None:
    """Noise cannot be compressed: no run takes more room."""
    record = RunCollector(paper_scenario(), _Nothing())
    rng = np.random.default_rng(1)
    for minute in range(60):
        t_ns = (np.arange(6_000) + 6_000 * minute) * 10 * MS
        for table, details in ((record.ticks, record.tick_details), (record.states, record.state_details)):
            values = rng.random((len(table.envelopes) + len(table.firsts), t_ns.size))
            table.add(t_ns, values)
            for at in range(0, t_ns.size, DETAIL):
                details.add(DetailBlock(t_ns[at : at + DETAIL], values[:, at : at + DETAIL]))
    assert 0.4 * NUMBERS < record.ticks.low.size + record.ticks.high.size <= NUMBERS
    payload = run_payload(record, label="hour")
    assert payload["end_s"] == pytest.approx(3600, rel=0.01)
    assert 1_000_000 < len(json.dumps(payload)) < 4_800_000


class _Nothing:
    """Evaluator that is never asked."""


def test_an_empty_slice_changes_nothing() -> None:
    record = RunCollector(paper_scenario(), _Nothing())
    record.take(LogSlice({}))
    assert run_events(record) == []
