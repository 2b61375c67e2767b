import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from barrier_examples import disk
from closed_form_log import circle_messages, write_log
from closed_form_series import run_series
from hypothesis import given
from hypothesis import strategies as st
from passafe_dashboard.errors import SeriesError
from passafe_dashboard.number_text import number
from passafe_dashboard.run_description import descriptions
from passafe_dashboard.run_series import StatusSpan, series_of, status_spans
from passafe_protocol.messages import FilterStatus
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog

A, B = FilterStatus.PASSED, FilterStatus.MODIFIED


def test_position_is_the_first_two_states() -> None:
    series = run_series(10)
    assert np.array_equal(series.position(0), series.x[:2])


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("times_s", np.zeros((2, 5))),
        ("times_s", np.zeros(0)),
        ("x", np.zeros((4, 9))),
        ("x", np.zeros(10)),
        ("x", np.zeros((1, 10))),
        ("u", np.zeros((2, 9))),
        ("h", np.zeros((2, 10))),
        ("h", np.zeros(10)),
        ("power_margin_w", np.zeros((1, 10))),
    ],
)
def test_mismatched_arrays_are_refused(field: str, value: Any) -> None:  # noqa: ANN401 - arrays
    with pytest.raises(SeriesError) as refused:
        replace(run_series(10), **{field: value})
    assert "allowed" in str(refused.value)


def test_ticks_of_equal_status_are_joined() -> None:
    ticks = [(0.0, A), (0.001, A), (0.002, B), (0.003, A)]
    assert status_spans(ticks, period_s=0.001) == (
        StatusSpan(A, 0.0, 0.002),
        StatusSpan(B, 0.002, 0.003),
        StatusSpan(A, 0.003, 0.004),
    )


def test_missing_ticks_leave_a_hole() -> None:
    spans = status_spans([(0.0, A), (0.5, A)], period_s=0.001)
    assert spans == (StatusSpan(A, 0.0, 0.001), StatusSpan(A, 0.5, 0.501))


@given(st.lists(st.sampled_from(list(FilterStatus)), max_size=100))
def test_spans_have_the_status_of_every_tick(statuses: list[FilterStatus]) -> None:
    spans = status_spans(((k * 1e-3, status) for k, status in enumerate(statuses)), period_s=1e-3)
    middles = [(k + 0.5) * 1e-3 for k in range(len(statuses))]
    found = [next(s.status for s in spans if s.start_s <= t < s.end_s) for t in middles]
    assert found == statuses
    assert all(one.status is not other.status for one, other in itertools.pairwise(spans))


def test_lowest_of_many_barriers_are_shown() -> None:
    series = run_series(100)
    disks = tuple(disk(f"disk {n}") for n in range(10))
    many = replace(series, barriers=disks, h=np.vstack([series.h + 9 - n for n in range(10)]))
    assert many.lowest_barriers == tuple(range(2, 10))
    words = descriptions(many)["h"]
    assert "disk 2 lowest sample" in words
    assert "disk 1 lowest sample" not in words
    assert f"2 others not shown, none below {number(series.h.min() + 8)}" in words


def test_two_robots_have_a_path_each() -> None:
    assert descriptions(replace(run_series(100), points=2))["plane"].count("Path of the robot") == 2


def test_series_of_a_log_hold_the_measurements_of_the_plant(tmp_path: Path) -> None:
    log = RunLog.read(write_log(tmp_path / "run.mcap", circle_messages(500)))
    series = series_of(log, CoreEvaluator(log.identity.scenario))
    assert series.times_s == pytest.approx(np.arange(500) * 1e-3)
    assert series.h[0] == pytest.approx(series.x[0] ** 2 + series.x[1] ** 2 - 1.0)
    # y = x₂ = 0 and V = ‖x‖² give h_u = yᵀu − 2x₁ᵀx₂ − 2x₂ᵀ(−σx₂ + u) = 0.
    assert series.power_margin_w == pytest.approx(np.zeros(500))
    assert {span.status for span in series.statuses} == {FilterStatus.PASSED, FilterStatus.MODIFIED}
