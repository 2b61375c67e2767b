"""Sessions that send side by side are judged each by its own numbers, with bounded memory."""

from passafe_protocol.messages import Header
from passafe_protocol.sequence import SESSIONS, Arrival, SequenceGuard, Session
from passafe_protocol.session_guards import SessionGuards, guard_of
from passafe_protocol.topics import COMMAND, STATE, STOP


def header(epoch: int, sequence: int) -> Header:
    return Header("operator", epoch, sequence, 0, 0, 0, 0)


def test_no_session_ends_another() -> None:
    guards = SessionGuards()

    found = [guards.classify(header(*each)) for each in ((5, 0), (9, 0), (5, 1), (2, 3), (9, 2), (5, 1))]

    assert found == [Arrival.FRESH] * 5 + [Arrival.DUPLICATE]
    assert (guards.received, guards.gaps, guards.refused) == (5, 1, 1)
    assert guards.sessions == (Session(2, 3, 3, 1), Session(9, 0, 2, 2), Session(5, 0, 1, 2))


def test_the_longest_silent_session_is_forgotten_first() -> None:
    guards = SessionGuards()
    guards.classify(header(1, 0))
    guards.classify(header(1, 2))
    guards.classify(header(1, 2))
    for epoch in range(2, SESSIONS + 2):
        guards.classify(header(epoch, 0))

    assert [session.epoch for session in guards.sessions] == list(range(2, SESSIONS + 2))
    assert (guards.received, guards.gaps, guards.refused) == (SESSIONS + 2, 1, 1)
    assert guards.classify(header(1, 2)) is Arrival.FRESH  # it begins anew


def test_memory_is_bounded_whatever_epochs_come() -> None:
    guards = SessionGuards()
    for epoch in range(20_000):
        guards.classify(header(epoch, 0))

    assert len(guards.sessions) == SESSIONS
    assert guards.received == 20_000


def test_the_table_decides_which_guard_a_topic_has() -> None:
    assert isinstance(guard_of(STOP), SessionGuards)
    assert isinstance(guard_of(COMMAND), SessionGuards)
    assert isinstance(guard_of(STATE), SequenceGuard)
