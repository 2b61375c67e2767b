"""Sessions of a sender: the current one is decided by what is received and by silence, never by a number."""

import itertools
import tracemalloc

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.messages import Header
from passafe_protocol.sequence import COUNT_MAX, SESSIONS, SequenceGuard
from passafe_protocol.sequence_window import BURST, Arrival, MissingRange, Session

MS = 1_000_000
HOLD_NS = 250 * MS
ACCEPTED = (Arrival.FRESH, Arrival.REORDERED)


def header(epoch: int, sequence: int) -> Header:
    return Header("plant", epoch, sequence, 0, 0, 0, 0)


def classify(guard: SequenceGuard, at_ms: float, epoch: int, *sequences: int) -> list[Arrival]:
    return [guard.classify(header(epoch, sequence), round(at_ms * MS)) for sequence in sequences]


def test_nothing_came_yet() -> None:
    guard = SequenceGuard(HOLD_NS)
    assert (guard.received, guard.gaps, guard.refused, guard.term) == (0, 0, 0, 0)
    assert (guard.epoch, guard.sessions, guard.newest_possible(0)) == (-1, (), -1)


@pytest.mark.parametrize("other", [0, 1, 2**64 - 1], ids=["zero", "older", "far future"])
def test_stranger_takes_no_place_of_a_current_session(other: int) -> None:
    guard = SequenceGuard(HOLD_NS)
    for k in range(1_000):
        assert classify(guard, 2 * k, 5_000, k) == [Arrival.FRESH]
        assert classify(guard, 2 * k + 1, other, k, 10**8 + k) == [Arrival.FOREIGN] * 2
    assert (guard.received, guard.gaps, guard.refused, guard.term, guard.epoch) == (1_000, 0, 2_000, 0, 5_000)
    assert guard.sessions == (Session(5_000, 0, 999, 1_000),)


@pytest.mark.parametrize("epoch", [3, 9], ids=["clock set back", "clock ahead"])
def test_restarted_sender_is_accepted_after_the_hold(epoch: int) -> None:
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 7, 40, 41)
    assert classify(guard, 249, epoch, 0, 1) == [Arrival.FOREIGN] * 2
    assert classify(guard, 250, epoch, 2, 3) == [Arrival.FRESH] * 2
    assert (guard.epoch, guard.term, guard.gaps) == (epoch, 1, 0)


def test_only_the_current_session_has_missing_messages() -> None:
    guard = SequenceGuard(HOLD_NS)
    assert guard.missing() == []
    classify(guard, 0, 1, 0, 3)
    assert guard.missing() == [MissingRange(1, 1, 2)]
    classify(guard, 1_000, 2, 5, 7)
    assert guard.missing() == [MissingRange(2, 6, 6)]


def test_only_accepted_messages_keep_the_place() -> None:
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 7, 40, 41)
    for at_ms in range(10, 250, 10):  # copies, and numbers out of reach
        assert classify(guard, at_ms, 7, 40, 10**9) == [Arrival.DUPLICATE, Arrival.FAR_AHEAD]
    assert classify(guard, 250, 8, 0) == [Arrival.FRESH]


def test_copies_of_an_ended_session_do_not_return() -> None:
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 7, *range(100))
    classify(guard, 300, 8, 0, 1)
    assert set(classify(guard, 900, 7, *range(100))) == {Arrival.FOREIGN}
    assert classify(guard, 901, 8, 2) == [Arrival.FRESH]
    assert (guard.epoch, guard.term) == (8, 1)


def test_displaced_sender_goes_on_after_the_strangers_silence() -> None:
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 7, 40, 41)
    assert classify(guard, 400, 2**64 - 1, 0) == [Arrival.FRESH]  # in a pause of the rightful one
    assert classify(guard, 410, 7, 42) == [Arrival.FOREIGN]
    assert classify(guard, 650, 7, 10**9) == [Arrival.FAR_AHEAD]
    assert classify(guard, 650, 7, 160, 161) == [Arrival.FRESH] * 2
    assert (guard.epoch, guard.term) == (7, 2)
    assert guard.sessions == (Session(2**64 - 1, 0, 0, 1), Session(7, 40, 161, 4))
    assert guard.gaps == 160 - 42


def test_flood_of_forged_sessions_displaces_no_memory() -> None:
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 1, 0, 1)
    classify(guard, 300, 2, 0, 1)
    tracemalloc.start()
    for k in range(20_000):
        classify(guard, 300 + k / 100, 10 + k, k)
        if not k % 1_000:
            classify(guard, 300 + k / 100, 2, 2 + k // 1_000)
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak_bytes < 20_000
    assert [session.epoch for session in guard.sessions] == [1, 2]


def test_only_sessions_that_were_current_are_remembered() -> None:
    guard = SequenceGuard(HOLD_NS)
    for k in range(3 * SESSIONS):
        classify(guard, 300 * k, k, 0, 2)
    assert [session.epoch for session in guard.sessions] == list(range(2 * SESSIONS, 3 * SESSIONS))
    assert (guard.received, guard.gaps, guard.term) == (6 * SESSIONS, 3 * SESSIONS, 3 * SESSIONS - 1)


def test_gaps_stay_what_health_can_carry() -> None:
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 1, 0, 1)
    classify(guard, 10**13, 1, 10**12)  # in 300 years
    assert guard.gaps == 10**12 - 2
    guard._gaps_forgotten = COUNT_MAX
    assert guard.gaps == COUNT_MAX


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(1, 5), st.integers(0, 2**64 - 1), st.integers(0, 2**64 - 1)), max_size=80))
def test_no_stranger_stops_a_sender_in_time(forged: list[tuple[int, int, int]]) -> None:
    """Whatever a stranger sends under other epochs, every message of the rightful sender is accepted."""
    guard, k = SequenceGuard(HOLD_NS), itertools.count()
    own = 2**60
    for pause_ms, epoch, sequence in forged:
        assert classify(guard, 10 * next(k), own, next(k)) == [Arrival.FRESH]
        if epoch != own:
            assert classify(guard, 10 * next(k) + pause_ms, epoch, sequence) == [Arrival.FOREIGN]
    assert guard.term == 0


@settings(deadline=None)
@given(st.lists(st.integers(0, 2**64 - 1), min_size=1, max_size=30))
def test_forged_numbers_of_the_session_cost_a_burst(forged: list[int]) -> None:
    """A stranger who knows the session costs at most so many messages of it, each time a number in reach is guessed."""
    guard = SequenceGuard(HOLD_NS)
    classify(guard, 0, 5, 0, 1)
    taken = {number for number in forged if classify(guard, 2, 5, number)[0] in ACCEPTED}
    reach = len(taken) * (BURST + 8)
    arrivals = classify(guard, 4, 5, *range(2, 2 + reach + 10))
    assert [k for k, arrival in enumerate(arrivals, 2) if arrival not in ACCEPTED] == sorted(taken)
