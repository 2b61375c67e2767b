"""Numbers of one session, against cases by hand and an oracle that remembers each."""

import tracemalloc
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.sequence_window import BURST, MAX_RATE_HZ, WINDOW, Arrival, SequenceWindow, WindowSize

MS = 1_000_000
S = 1_000 * MS


def window_of(*sequences: int, now_ns: int = 0) -> SequenceWindow:
    window = SequenceWindow(sequences[0], now_ns)
    for sequence in sequences[1:]:
        assert window.classify(sequence, now_ns) in (Arrival.FRESH, Arrival.REORDERED)
    return window


def test_lost_messages_are_gaps_and_late_ones_close_them() -> None:
    window = window_of(0, 3, 10)
    assert (window.received, window.gaps) == (3, 8)
    assert window.classify(2, 0) is Arrival.REORDERED
    assert (window.received, window.gaps) == (4, 7)


def test_missing_numbers_are_known_as_far_as_the_window_reaches() -> None:
    assert window_of(3, 4, 7, 5, 9).missing() == [(6, 6), (8, 8)]
    assert window_of(0).missing() == []
    window = SequenceWindow(0, 0, WindowSize(remembered=4))
    for number in (1, 3, 6):
        window.classify(number, 0)
    assert (window.gaps, window.missing()) == (3, [(4, 5)])


def test_a_late_reader_has_no_gap_before_its_first_message() -> None:
    assert window_of(1000, 1001).gaps == 0


def test_a_late_message_before_the_first_opens_a_gap() -> None:
    assert window_of(5, 2).gaps == 2  # 3 and 4


@pytest.mark.parametrize("again", [0, 7, 8], ids=["oldest", "middle", "newest"])
def test_repeated_numbers_are_duplicates(again: int) -> None:
    window = window_of(*range(9))
    assert [window.classify(again, 0), window.classify(again, 0)] == [Arrival.DUPLICATE] * 2
    assert (window.received, window.gaps) == (9, 0)


def test_window_has_its_stated_size() -> None:
    window = window_of(0, 1)
    newest = 10 * WINDOW
    assert window.classify(newest, 60 * S) is Arrival.FRESH
    assert window.classify(newest - WINDOW + 1, 60 * S) is Arrival.REORDERED
    assert window.classify(newest - WINDOW, 60 * S) is Arrival.DUPLICATE


def test_far_number_is_refused_until_time_explains_it() -> None:
    window = window_of(7, 8)
    assert window.classify(8 + BURST + 1, 0) is Arrival.FAR_AHEAD
    assert window.classify(8 + BURST, 0) is Arrival.FRESH
    cut_s = 3
    assert window.classify(8 + 2 * BURST + MAX_RATE_HZ * cut_s + 1, cut_s * S) is Arrival.FAR_AHEAD
    assert window.classify(8 + 2 * BURST + MAX_RATE_HZ * cut_s, cut_s * S) is Arrival.FRESH


@pytest.mark.parametrize("forged", [10**8, 2**64 - 1])
def test_refused_number_changes_nothing(forged: int) -> None:
    window = window_of(4, 5)
    for k in range(6, 40):
        assert window.classify(forged, k * MS) is Arrival.FAR_AHEAD
        assert window.classify(k, k * MS) is Arrival.FRESH
    assert (window.newest, window.received, window.gaps) == (39, 36, 0)


@pytest.mark.parametrize("forged", [0, 2**64 - 1])
def test_forged_first_number_does_not_count(forged: int) -> None:
    window = SequenceWindow(forged, 0)
    assert window.classify(9_000, MS) is Arrival.FRESH
    assert window.classify(9_001, 2 * MS) is Arrival.FRESH
    assert window.classify(forged, 3 * MS) in (Arrival.FAR_AHEAD, Arrival.DUPLICATE)
    assert (window.first, window.newest, window.received, window.gaps) == (9_000, 9_001, 2, 0)


def test_memory_does_not_grow_with_the_numbers() -> None:
    window = window_of(0, 1)
    tracemalloc.start()
    for k in range(1, 2 * WINDOW):
        window.classify(k * MAX_RATE_HZ, k * S)
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak_bytes < 50_000
    assert window._seen.bit_length() <= WINDOW


class Oracle:
    """The same judgement by remembering every number."""

    def __init__(self, first: int, size: WindowSize) -> None:
        self.size, self.burst = size
        self.seen = {first}
        self.accepted_ns = 0

    def classify(self, sequence: int, now_ns: int) -> Arrival:
        """Classify a message by all messages before it."""
        newest = max(self.seen)
        is_far = sequence - newest > self.burst + MAX_RATE_HZ * (now_ns - self.accepted_ns) // S
        if len(self.seen) == 1 and (is_far or sequence <= newest - self.size):
            self.seen.clear()
            newest = -1
        elif is_far:
            return Arrival.FAR_AHEAD
        elif sequence in self.seen or sequence <= newest - self.size:
            return Arrival.DUPLICATE
        self.seen.add(sequence)
        self.accepted_ns = now_ns
        return Arrival.FRESH if sequence > newest else Arrival.REORDERED

    def missing(self) -> set[int]:
        """Return the numbers that did not come, as far as a window reaches back."""
        newest = max(self.seen)
        return {*range(max(min(self.seen), newest - self.size + 1), newest)} - self.seen


NUMBERS = st.one_of(
    st.integers(0, 20), st.integers(WINDOW - 3, WINDOW + 3), st.integers(0, 9 * WINDOW), st.integers(0, 2**64 - 1)
)


@settings(deadline=None)
@given(
    st.sampled_from((WindowSize(), WindowSize(7, 3), WindowSize(WINDOW, 5 * WINDOW))),
    NUMBERS,
    st.lists(st.tuples(st.integers(0, 2 * S), NUMBERS), max_size=60),
)
def test_agrees_with_an_oracle_that_forgets_nothing(
    size: WindowSize, first: int, stream: list[tuple[int, int]]
) -> None:
    window, oracle, now_ns = SequenceWindow(first, 0, size), Oracle(first, size), 0
    for pause_ns, sequence in stream:
        now_ns += pause_ns
        assert window.classify(sequence, now_ns) is oracle.classify(sequence, now_ns)
        assert window.received == len(oracle.seen)
        assert window.gaps == max(oracle.seen) - min(oracle.seen) + 1 - len(oracle.seen)
    ranges = window.missing()
    assert {number for begin, end in ranges for number in range(begin, end + 1)} == oracle.missing()
    assert all(end + 1 < begin for (_, end), (begin, _) in pairwise(ranges))
