"""The largest of the last second or two, by the sender's clock."""

from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol.messages import Header, PlantInput, Received
from passafe_services.plant.transit_time import SPAN_NS, TransitTime

MS = 1_000_000


def an_input(epoch: int, term: int = 0) -> Received:
    return Received(Header("filter", epoch, 0, 0, 0, 0, 0), PlantInput(1, (0.0,), 0, 0), 0, term)


def test_it_is_plant_time_of_arrival_minus_senders_clock() -> None:
    transit = TransitTime()
    assert (transit.epoch, transit.largest_ns) == (0, 0)

    transit.record(an_input(7), 100 * MS, 5_000 * MS)

    assert (transit.epoch, transit.largest_ns) == (7, -4_900 * MS)


def test_maximum_is_kept_for_one_to_two_spans() -> None:
    transit, found = TransitTime(), {}
    for arrival_ms in range(0, 4_000, 10):
        late_ms = 50 if arrival_ms == 990 else 3
        transit.record(an_input(1), arrival_ms * MS, (arrival_ms - late_ms) * MS)
        found[arrival_ms] = transit.largest_ns // MS

    assert (found[980], found[990], found[1_990]) == (3, 50, 50)
    assert [found[ms] for ms in (2_000, 3_990)] == [3, 3]
    assert SPAN_NS == 1_000 * MS


def test_early_maximum_is_kept_until_the_end_of_the_next_span() -> None:
    transit, found = TransitTime(), {}
    for arrival_ms in range(0, 4_000, 10):
        late_ms = 50 if arrival_ms == 1_000 else 3
        transit.record(an_input(1), arrival_ms * MS, (arrival_ms - late_ms) * MS)
        found[arrival_ms] = transit.largest_ns // MS

    assert [found[ms] for ms in (990, 1_000, 2_990, 3_000)] == [3, 50, 50, 3]


def test_new_session_resets_and_ended_session_is_ignored() -> None:
    transit = TransitTime()
    transit.record(an_input(9, term=4), 100 * MS, 90 * MS)

    transit.record(an_input(20, term=3), 110 * MS, 0)
    assert (transit.epoch, transit.largest_ns) == (9, 10 * MS)
    transit.record(an_input(3, term=5), 120 * MS, 119 * MS)
    assert (transit.epoch, transit.largest_ns) == (3, MS)
    assert transit.is_ended(an_input(9, term=4))
    assert not transit.is_ended(an_input(9, term=6))  # the same session, back in its place


def test_after_silence_the_last_span_counts_once_more() -> None:
    transit = TransitTime()
    transit.record(an_input(1), 0, -50 * MS)

    transit.record(an_input(1), 60_000 * MS, 59_997 * MS)
    assert transit.largest_ns == 50 * MS
    transit.record(an_input(1), 61_000 * MS, 60_997 * MS)
    assert transit.largest_ns == 3 * MS


@given(st.lists(st.tuples(st.integers(0, 400 * MS), st.integers(-50 * MS, 300 * MS)), min_size=1, max_size=60))
def test_it_covers_at_least_the_last_second(arrivals: list[tuple[int, int]]) -> None:
    transit, now_ns, seen = TransitTime(), 0, []
    for gap_ns, transit_ns in arrivals:
        now_ns += gap_ns
        seen.append((now_ns, transit_ns))
        transit.record(an_input(1), now_ns, now_ns - transit_ns)
        lately = [each for at_ns, each in seen if at_ns > now_ns - SPAN_NS]
        assert max(lately) <= transit.largest_ns <= max(each for _, each in seen)
