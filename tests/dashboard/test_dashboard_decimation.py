import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from passafe_dashboard.decimation import DecimatedSeries, Keep, kept_samples

BIN_NS = 10
COLUMNS = {"low": Keep.LOWEST, "high": Keep.HIGHEST, "last": Keep.LAST}

values = st.floats(-1e9, 1e9)
steps_ns = st.integers(-30, 120)


def series(capacity: int = 10_000) -> DecimatedSeries:
    return DecimatedSeries(COLUMNS, bin_ns=BIN_NS, capacity=capacity)


def flush(made: DecimatedSeries) -> None:
    """Close the open bin by a sample far in the future."""
    made.add(10**9, [1e300, -1e300, 0.0])


@given(st.lists(st.tuples(steps_ns, values), min_size=1))
def test_no_minimum_and_no_maximum_is_ever_lost(samples: list[tuple[int, float]]) -> None:
    made = series()
    time_ns = 0
    for step_ns, value in samples:
        time_ns += step_ns
        made.add(time_ns, [value, value, value])
    flush(made)
    rows = [row.values for row in made.since(0).rows if row.values[0] is not None]
    assert min(row[0] for row in rows if row[0] is not None) == min(value for _, value in samples)
    assert max(row[1] for row in rows if row[1] is not None) == max(value for _, value in samples)


@given(st.lists(st.tuples(st.integers(0, 40), values), min_size=1), st.data())
def test_a_reader_that_polls_at_any_moment_sees_each_row_once(
    samples: list[tuple[int, float]], data: st.DataObject
) -> None:
    made = series()
    seen, cursor, time_ns = [], 0, 0
    for step_ns, value in samples:
        time_ns += step_ns
        made.add(time_ns, [value] * 3)
        if data.draw(st.booleans()):
            batch = made.since(cursor)
            seen += batch.rows
            cursor = batch.cursor
            assert batch.lost == 0
    seen += made.since(cursor).rows
    assert [row.number for row in seen] == list(range(len(seen)))
    assert tuple(seen) == made.since(0).rows


def test_a_dip_of_one_sample_survives() -> None:
    made = series()
    for time_ns in range(100):
        made.add(time_ns, [-1.0 if time_ns == 57 else 5.0, 0.0, 0.0])
    flush(made)
    rows = made.since(0).rows
    assert [row.values[0] for row in rows[:10]] == [5.0] * 5 + [-1.0] + [5.0] * 4
    assert (rows[5].start_s, rows[5].end_s) == (50e-9, 60e-9)


def test_last_value_represents_a_bin_on_request() -> None:
    made = series()
    for time_ns, value in ((0, 1.0), (3, 9.0), (9, 4.0)):
        made.add(time_ns, [0.0, 0.0, value])
    flush(made)
    assert made.since(0).rows[0].values[2] == 4.0


def test_a_slow_reader_learns_how_many_rows_it_lost() -> None:
    made = series(capacity=5)
    for number in range(21):
        made.add(number * BIN_NS, [float(number)] * 3)
    batch = made.since(0)
    assert batch.lost == 15
    assert [row.number for row in batch.rows] == [15, 16, 17, 18, 19]
    assert batch.cursor == 20
    assert made.first == 15


def test_an_interruption_is_marked_by_a_row_of_nothing() -> None:
    made = series()
    made.add(0, [1.0] * 3)
    made.add(20 * BIN_NS, [2.0] * 3)
    made.add(21 * BIN_NS, [3.0] * 3)
    rows = made.since(0).rows
    assert [row.values[0] for row in rows] == [1.0, None, 2.0]
    assert (rows[1].start_s, rows[1].end_s) == (10e-9, 200e-9)


def test_short_waits_are_no_interruption() -> None:
    made = series()
    made.add(0, [1.0] * 3)
    made.add(8 * BIN_NS, [2.0] * 3)
    made.add(9 * BIN_NS, [2.0] * 3)
    assert [row.values[0] for row in made.since(0).rows] == [1.0, 2.0]


@given(
    st.lists(st.tuples(values, values), min_size=1, max_size=200),
    st.integers(1, 30),
)
def test_kept_samples_hold_the_extremes_of_every_column(samples: list[tuple[float, float]], bins: int) -> None:
    columns = list(np.array(samples).T)
    kept = kept_samples(columns, bins=bins)
    assert np.all(np.diff(kept) > 0)
    assert kept[0] == 0
    assert kept[-1] == len(samples) - 1
    assert len(kept) <= max(2 * bins, 2 * bins * len(columns) + 2)
    for column in columns:
        assert column[kept].min() == column.min()
        assert column[kept].max() == column.max()


def test_kept_samples_of_few_samples_are_all() -> None:
    assert kept_samples([np.arange(7.0)], bins=4).tolist() == list(range(7))


def test_kept_samples_of_no_column_are_none() -> None:
    assert kept_samples([], bins=4).size == 0


def test_what_is_no_number_is_kept() -> None:
    column = np.zeros(1000)
    column[333] = np.nan
    assert 333 in kept_samples([column], bins=10)
