"""Sessions that send side by side are judged each by its own numbers, with bounded memory."""

from passafe_protocol.messages import Header
from passafe_protocol.sequence import SESSIONS, SequenceGuard
from passafe_protocol.sequence_window import Arrival, MissingRange, Session
from passafe_protocol.session_guards import SessionGuards, guard_of, hold_ns
from passafe_protocol.topics import COMMAND, HEALTH, INPUT, LEASE, LINK_CONFIG, STATE, STOP, TOPICS


def header(epoch: int, sequence: int) -> Header:
    return Header("operator", epoch, sequence, 0, 0, 0, 0)


def test_no_session_ends_another() -> None:
    guards = SessionGuards()

    found = [guards.classify(header(*each), 0) for each in ((5, 0), (9, 0), (5, 1), (2, 3), (9, 2), (5, 1))]

    assert found == [Arrival.FRESH] * 5 + [Arrival.DUPLICATE]
    assert (guards.received, guards.gaps, guards.refused) == (5, 1, 1)
    assert guards.sessions == (Session(2, 3, 3, 1), Session(9, 0, 2, 2), Session(5, 0, 1, 2))
    assert guards.missing() == [MissingRange(9, 1, 1)]


def test_the_longest_silent_session_is_forgotten_first() -> None:
    guards = SessionGuards()
    guards.classify(header(1, 0), 0)
    guards.classify(header(1, 2), 0)
    guards.classify(header(1, 2), 0)
    for epoch in range(2, SESSIONS + 2):
        guards.classify(header(epoch, 0), 0)

    assert [session.epoch for session in guards.sessions] == list(range(2, SESSIONS + 2))
    assert (guards.received, guards.gaps, guards.refused) == (SESSIONS + 2, 1, 1)
    assert guards.classify(header(1, 2), 0) is Arrival.FRESH  # it begins anew


def test_memory_is_bounded_whatever_epochs_come() -> None:
    guards = SessionGuards()
    for epoch in range(20_000):
        guards.classify(header(epoch, 0), 0)

    assert len(guards.sessions) == SESSIONS
    assert guards.received == 20_000


def test_the_table_decides_which_guard_a_topic_has() -> None:
    assert isinstance(guard_of(STOP), SessionGuards)
    assert isinstance(guard_of(COMMAND), SessionGuards)
    assert isinstance(guard_of(LINK_CONFIG), SessionGuards)
    assert isinstance(guard_of(STATE), SequenceGuard)


def test_far_number_of_a_session_is_refused() -> None:
    guards = SessionGuards()
    assert (guards.epoch, guards.newest_possible(0), guards.term) == (-1, -1, 0)
    guards.classify(header(4, 10), 0)
    guards.classify(header(4, 11), 0)

    assert guards.classify(header(4, 10**9), 0) is Arrival.FAR_AHEAD
    assert guards.classify(header(4, 12), 0) is Arrival.FRESH
    assert (guards.received, guards.refused, guards.epoch) == (3, 1, 4)
    assert guards.newest_possible(0) < 10**9


def test_a_sender_in_time_is_received_within_the_hold() -> None:
    for topic in TOPICS:
        assert hold_ns(topic) >= 250_000_000
        assert not topic.rate_hz or hold_ns(topic) > 1e9 / topic.rate_hz
    assert hold_ns(INPUT) == hold_ns(STATE) == 250_000_000  # a restarted one is back in well under 1 s
    assert (hold_ns(LEASE), hold_ns(HEALTH)) == (300_000_000, 1_500_000_000)
