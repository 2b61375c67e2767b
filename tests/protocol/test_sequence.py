"""Judgement by epoch and sequence number, against cases by hand and an oracle."""

import tracemalloc
from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.messages import Header
from passafe_protocol.sequence import SESSIONS, WINDOW, Arrival, SequenceGuard, Session


def header(sequence: int, epoch: int = 1) -> Header:
    return Header("plant", epoch, sequence, 0, 0, 0, 0)


def classify_all(guard: SequenceGuard, *sequences: int) -> list[Arrival]:
    return [guard.classify(header(sequence)) for sequence in sequences]


def test_nothing_came_yet() -> None:
    guard = SequenceGuard()

    assert (guard.received, guard.gaps, guard.refused) == (0, 0, 0)


def test_in_order() -> None:
    guard = SequenceGuard()

    assert classify_all(guard, 0, 1, 2) == [Arrival.FRESH] * 3
    assert (guard.received, guard.gaps, guard.refused) == (3, 0, 0)


def test_lost_messages_are_gaps() -> None:
    guard = SequenceGuard()

    classify_all(guard, 0, 3, 10)

    assert (guard.received, guard.gaps) == (3, 8)


def test_a_late_reader_has_no_gap_before_its_first_message() -> None:
    guard = SequenceGuard()

    classify_all(guard, 1000, 1001)

    assert guard.gaps == 0


def test_reordered_message_closes_its_gap() -> None:
    guard = SequenceGuard()

    assert classify_all(guard, 0, 2, 1) == [Arrival.FRESH, Arrival.FRESH, Arrival.REORDERED]
    assert (guard.received, guard.gaps, guard.refused) == (3, 0, 0)


def test_reordered_message_before_the_first_opens_a_gap() -> None:
    guard = SequenceGuard()

    assert classify_all(guard, 5, 2) == [Arrival.FRESH, Arrival.REORDERED]
    assert guard.gaps == 2  # 3 and 4


@pytest.mark.parametrize("again", [0, 7, 8], ids=["oldest", "middle", "newest"])
def test_repeated_message_is_refused_once_for_each_repetition(again: int) -> None:
    guard = SequenceGuard()
    classify_all(guard, *range(9))

    assert classify_all(guard, again, again) == [Arrival.DUPLICATE] * 2
    assert (guard.received, guard.gaps, guard.refused) == (9, 0, 2)


def test_window_has_its_stated_size() -> None:
    guard = SequenceGuard()
    newest = 10 * WINDOW
    classify_all(guard, 0, newest)

    assert WINDOW >= 1024
    assert classify_all(guard, newest - WINDOW + 1) == [Arrival.REORDERED]
    assert classify_all(guard, newest - WINDOW) == [Arrival.DUPLICATE]


def test_older_epoch_is_an_ended_session_without_side_effects() -> None:
    guard = SequenceGuard()
    guard.classify(header(4, epoch=7))

    assert guard.classify(header(5, epoch=6)) is Arrival.ENDED_SESSION
    assert guard.classify(header(5, epoch=7)) is Arrival.FRESH
    assert (guard.received, guard.gaps, guard.refused) == (2, 0, 1)


def test_newer_epoch_starts_a_session_and_keeps_the_counts() -> None:
    guard = SequenceGuard()
    classify_all(guard, 10, 13)

    assert guard.classify(header(0, epoch=2)) is Arrival.FRESH
    assert guard.classify(header(0, epoch=2)) is Arrival.DUPLICATE
    assert guard.classify(header(2, epoch=2)) is Arrival.FRESH
    assert (guard.received, guard.gaps, guard.refused) == (4, 3, 1)


def test_epoch_zero_is_an_epoch() -> None:
    guard = SequenceGuard()

    assert guard.classify(header(0, epoch=0)) is Arrival.FRESH
    assert guard.classify(header(0, epoch=0)) is Arrival.DUPLICATE


def test_a_huge_jump_forgets_the_window() -> None:
    guard = SequenceGuard()

    assert classify_all(guard, 0, 2**64 - 1, 0, 1) == [
        Arrival.FRESH,
        Arrival.FRESH,
        Arrival.DUPLICATE,
        Arrival.DUPLICATE,
    ]
    assert guard.gaps == 2**64 - 2


@pytest.mark.parametrize("step", [1, WINDOW - 1, 10**8])
def test_memory_does_not_grow_with_the_numbers(step: int) -> None:
    guard = SequenceGuard()
    tracemalloc.start()
    for i in range(WINDOW + 100):
        guard.classify(header(i * step))
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert peak_bytes < 100_000
    assert guard._seen.bit_length() <= WINDOW


def test_gaps_stay_what_health_can_carry() -> None:
    guard = SequenceGuard()
    for epoch in range(3):
        guard.classify(header(0, epoch))
        guard.classify(header(2**64 - 1, epoch))

    assert guard.gaps == 2**64 - 1


@dataclass
class Oracle:
    """The same judgement by remembering every number."""

    epoch: int = -1
    seen: set[int] = field(default_factory=set)
    gaps_before: int = 0

    def gaps(self) -> int:
        """Numbers between first and newest that were not seen, in all epochs."""
        here = max(self.seen) - min(self.seen) + 1 - len(self.seen) if self.seen else 0
        return min(self.gaps_before + here, 2**64 - 1)

    def classify(self, message: Header) -> Arrival:
        """Classify a message by all messages before it."""
        if message.epoch < self.epoch:
            return Arrival.ENDED_SESSION
        if message.epoch > self.epoch:
            self.gaps_before, self.epoch, self.seen = self.gaps(), message.epoch, {message.sequence}
            return Arrival.FRESH
        newest = max(self.seen)
        if message.sequence in self.seen or message.sequence <= newest - WINDOW:
            return Arrival.DUPLICATE
        self.seen.add(message.sequence)
        return Arrival.FRESH if message.sequence > newest else Arrival.REORDERED


NUMBERS = st.one_of(
    st.integers(0, 20),
    st.integers(WINDOW - 3, WINDOW + 3),
    st.integers(2 * WINDOW - 3, 2 * WINDOW + 3),
    st.integers(0, 2**64 - 1),
)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 2), NUMBERS), max_size=60))
def test_agrees_with_an_oracle_that_forgets_nothing(stream: list[tuple[int, int]]) -> None:
    guard, oracle = SequenceGuard(), Oracle()
    classified = []
    for epoch, sequence in stream:
        message = header(sequence, epoch)
        classified.append(guard.classify(message))
        assert classified[-1] is oracle.classify(message)
        assert guard.gaps == oracle.gaps()
    assert guard.received == classified.count(Arrival.FRESH) + classified.count(Arrival.REORDERED)
    assert guard.received + guard.refused == len(stream)


def test_sessions_have_their_counts_and_only_the_newest_are_kept() -> None:
    guard = SequenceGuard()
    assert guard.sessions == ()
    for epoch, sequence in ((1, 5), (1, 7), (1, 4), (3, 0), (2, 9), (3, 2), (3, 2)):
        guard.classify(Header("plant", epoch, sequence, 0, 0, 0, 0))
    assert guard.sessions == (Session(1, 4, 7, 3), Session(3, 0, 2, 2))
    for epoch in range(4, 30):
        guard.classify(Header("plant", epoch, 1, 0, 0, 0, 0))
    assert len(guard.sessions) == SESSIONS
    assert guard.sessions[-1] == Session(29, 1, 1, 1)
