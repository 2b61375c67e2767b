"""Percentiles of counted durations, beside NumPy's of the durations themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_services.tools.review import duration_histogram
from passafe_services.tools.review.duration_histogram import DurationHistogram


@given(st.lists(st.integers(-(2**40), 2**40), min_size=1, max_size=60), st.integers(1, 7))
def test_few_durations_are_counted_exactly(durations_ns: list[int], parts: int) -> None:
    histogram = DurationHistogram()
    for part in np.array_split(np.array(durations_ns, dtype=np.int64), parts):
        histogram.add(part)

    expected = np.percentile(np.array(durations_ns), [0, 25, 50, 99, 99.9])
    assert histogram.percentiles(0, 25, 50, 99, 99.9) == tuple(expected)
    assert (histogram.largest_ns, histogram.total) == (max(durations_ns), len(durations_ns))


def test_many_durations_are_counted_to_a_thousandth(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(duration_histogram, "MOST_EXACT", 4000)
    durations_ns = np.random.default_rng(1).lognormal(12, 2, 50_000).astype(np.int64)
    histogram = DurationHistogram()
    for part in np.array_split(durations_ns, 40):
        histogram.add(part)

    assert histogram._values.size <= 20_000
    expected = np.percentile(durations_ns, [1, 50, 99, 99.9])
    assert histogram.percentiles(1, 50, 99, 99.9) == pytest.approx(tuple(expected), rel=1.1e-3)
    assert histogram.largest_ns == durations_ns.max()


def test_nothing_counted_has_no_largest() -> None:
    histogram = DurationHistogram()
    histogram.add(np.zeros(0, dtype=np.int64))

    assert histogram.largest_ns is None
