"""Deadlines of a loop at a fixed rate."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st
from passafe_services.loop.pace import Pace

START_NS = 5_000_000_000
PERIOD_NS = 1_000_000


def test_deadlines_are_absolute_and_do_not_drift() -> None:
    pace = Pace(START_NS, 300.0)
    for _ in range(3_000):
        pace.end(pace.begin(pace.due_ns + 100) + 200)
    assert pace.due_ns == START_NS + 3_000 * 3_333_333
    assert pace.overruns == pace.skipped == 0


def test_a_late_step_does_not_shift_the_next() -> None:
    pace = Pace(START_NS, 1000.0)
    assert pace.begin(START_NS + 900_000) == START_NS
    pace.end(START_NS + 950_000)
    assert pace.due_ns == START_NS + PERIOD_NS


def test_an_overrun_is_a_step_that_ends_after_the_next_was_due() -> None:
    pace = Pace(START_NS, 1000.0)
    pace.begin(START_NS)
    pace.end(START_NS + PERIOD_NS)
    assert pace.overruns == 0
    pace.begin(START_NS + PERIOD_NS)
    pace.end(START_NS + 2 * PERIOD_NS + 1)
    assert pace.overruns == 1
    assert pace.skipped == 0


def test_missed_steps_are_skipped_without_a_burst() -> None:
    pace = Pace(START_NS, 1000.0)
    late_ns = 3_400_000
    assert pace.begin(START_NS + late_ns) == START_NS + 3 * PERIOD_NS
    pace.end(START_NS + late_ns + 10)
    assert (pace.steps, pace.skipped) == (1, 3)
    assert pace.due_ns == START_NS + 4 * PERIOD_NS
    assert pace.pop_max_lateness_ns() == late_ns
    assert pace.pop_max_lateness_ns() == 0


@given(
    st.lists(st.tuples(st.integers(0, 5_000_000), st.integers(0, 5_000_000)), max_size=60),
    st.sampled_from([10.0, 300.0, 1000.0, 1999.9]),
)
def test_every_due_step_is_made_or_missed_once(delays: list[tuple[int, int]], rate_hz: float) -> None:
    pace, period_ns = Pace(START_NS, rate_hz), round(1e9 / rate_hz)
    now_ns, scheduled = START_NS, []
    for oversleep_ns, work_ns in delays:
        now_ns = max(now_ns, pace.due_ns) + oversleep_ns
        scheduled.append(pace.begin(now_ns))
        assert 0 <= now_ns - scheduled[-1] < period_ns
        now_ns += work_ns
        pace.end(now_ns)
    assert all(later > earlier for earlier, later in pairwise(scheduled))
    assert pace.due_ns == START_NS + (pace.steps + pace.skipped) * period_ns
