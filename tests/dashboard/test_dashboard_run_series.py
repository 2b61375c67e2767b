import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from closed_form_series import run_series
from hypothesis import given
from hypothesis import strategies as st
from passafe_dashboard.errors import SeriesError
from passafe_dashboard.run_series import StatusSpan, status_spans
from passafe_protocol.messages import FilterStatus

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
