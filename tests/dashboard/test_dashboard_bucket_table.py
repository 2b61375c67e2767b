"""Level of detail: no extreme of a run is lost, however long it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from passafe_dashboard.run_record.bucket_table import BucketTable, Extreme, FloatArray, IntArray

MS = 1_000_000
VALUES = st.one_of(st.floats(-1e12, 1e12), st.just(np.nan))
SAMPLES = st.lists(st.tuples(st.integers(-50_000, 50_000), VALUES, VALUES), min_size=1, max_size=200)


def table(most: int = 16) -> BucketTable:
    return BucketTable(("a", "b"), ("p",), width_ns=MS, most=most)


def add(to: BucketTable, t_ns: IntArray, a: FloatArray, b: FloatArray) -> None:
    to.add(t_ns, np.vstack([a, b, np.arange(t_ns.size, dtype=np.float64)]))


def of_bucket(made: BucketTable, t_ns: IntArray) -> IntArray:
    return (t_ns - made.start_ns) // made.width_ns


@given(SAMPLES, st.integers(1, 60), st.integers(2, 20))
def test_every_sample_lies_in_the_envelope_of_its_bucket(
    samples: list[tuple[int, float, float]], block: int, most: int
) -> None:
    t_ns = np.array([t for t, _, _ in samples], dtype=np.int64) * MS // 7
    rows = np.array([values for _, *values in samples], dtype=np.float64).T
    made = table(most)
    for at in range(0, t_ns.size, block):
        part = slice(at, at + block)
        add(made, t_ns[part], rows[0, part], rows[1, part])
    assert made.count.size <= most
    assert made.count.sum() == t_ns.size
    bucket = of_bucket(made, t_ns)
    for row, name in enumerate(made.envelopes):
        for number in np.unique(bucket).tolist():
            here = rows[row, bucket == number]
            known = here[~np.isnan(here)]
            expected = (known.min(), known.max()) if known.size else (np.nan, np.nan)
            found = made.low[row, number], made.high[row, number]
            assert found == pytest.approx(expected, rel=0, abs=0, nan_ok=True)
        known = rows[row][~np.isnan(rows[row])]
        least, greatest = made.least(name), made.greatest(name)
        if known.size:
            assert least is not None
            assert greatest is not None
            assert (least.value, greatest.value) == (known.min(), known.max())
            assert least.at_ns in t_ns[rows[row] == least.value]
        else:
            assert least is None
            assert greatest is None


@given(arrays(np.int64, st.integers(1, 100), elements=st.integers(0, 10**7), unique=True), st.integers(2, 30))
def test_first_value_of_a_bucket_is_that_of_its_first_sample(t_us: IntArray, most: int) -> None:
    t_ns = np.sort(t_us) * 1000
    made = table(most)
    for at in range(0, t_ns.size, 7):
        part = slice(at, at + 7)
        numbers = np.arange(t_ns.size, dtype=np.float64)[part]
        made.add(t_ns[part], np.vstack([numbers, numbers, numbers]))
    assert made.first[0] == pytest.approx(made.low[0], rel=0, abs=0, nan_ok=True)


def test_a_dip_of_one_sample_in_an_hour_is_kept() -> None:
    made = BucketTable(("h",), width_ns=MS, most=1024)
    rng = np.random.default_rng(3)
    for second in range(3600):
        h = 1.0 + rng.random((1, 1000))
        if second == 2718:
            h[0, 281] = -0.125
        made.add((second * 1000 + np.arange(1000)) * MS, h)
    assert made.least("h") == Extreme(-0.125, 2_718_281 * MS)
    dips = np.flatnonzero(made.low[0] < 0)
    assert dips.tolist() == [(2_718_281 * MS - made.start_ns) // made.width_ns]
    assert 512 <= made.count.size <= 1024


def test_a_run_that_fits_keeps_every_sample() -> None:
    made = table(16)
    values = np.arange(10.0)
    add(made, np.arange(10) * MS, values, -values)
    assert made.width_ns == MS
    assert made.low[0].tolist() == made.high[0].tolist() == values.tolist()


def test_time_that_goes_back_is_put_in_its_place() -> None:
    made = table(16)
    add(made, np.array([9, 10]) * MS, np.array([1.0, 2.0]), np.zeros(2))
    add(made, np.array([4, 3]) * MS, np.array([4.0, 3.0]), np.zeros(2))
    assert made.start_ns == 3 * MS
    assert made.low[0].tolist() == pytest.approx([3, 4, *[np.nan] * 4, 1, 2], nan_ok=True)


def test_nothing_added_is_nothing_held() -> None:
    made = table()
    made.add(np.zeros(0, dtype=np.int64), np.zeros((3, 0)))
    assert made.count.size == 0
    assert made.least("a") is None
    made.widen()
    assert made.low.shape == (2, 0)
