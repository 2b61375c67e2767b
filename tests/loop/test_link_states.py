"""Newest states of links, and answers to requests."""

import tracemalloc

from msgspec.structs import replace
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkState
from passafe_services.loop.link_states import NewestLinkStates

STATE = MessageLink("plant-to-filter", LinkSettings()).state("period", ())


def head(sequence: int, *, epoch: int = 1, source: str = "filter") -> Header:
    return Header(source, epoch, sequence, 0, 0, 0, 0)


def asked(epoch: int, sequence: int) -> LinkState:
    return replace(STATE, config_source="console", config_epoch=epoch, config_sequence=sequence)


def test_newest_state_of_the_current_session_counts() -> None:
    states = NewestLinkStates()
    assert states.newest("plant-to-filter") is None
    for at_s, sequence, epoch in ((0, 0, 5), (1, 5, 5), (2, 4, 5), (2.5, 0, 2), (4, 1, 2), (5, 7, 9)):
        states.receive(head(sequence, epoch=epoch), STATE, round(1e9 * at_s))
    newest = states.newest("plant-to-filter")

    assert newest is not None
    assert (newest.header.epoch, newest.header.sequence, newest.received_ns) == (2, 1, 4_000_000_000)
    assert states.newest("filter-to-plant") is None


def test_forged_sessions_cost_no_memory() -> None:
    states = NewestLinkStates()
    tracemalloc.start()
    for epoch in range(20_000):
        states.receive(head(epoch, epoch=epoch), STATE, 75_000 * epoch)
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert peak_bytes < 50_000
    newest = states.newest("plant-to-filter")
    assert newest is not None
    assert newest.header.epoch == 0


def test_reordered_state_is_ignored() -> None:
    states = NewestLinkStates()
    states.receive(head(2), asked(9, 4), 0)
    states.receive(head(1), STATE, 0)

    newest = states.newest("plant-to-filter")
    assert newest is not None
    assert newest.header.sequence == 2


def test_only_who_reads_the_link_is_believed() -> None:
    states = NewestLinkStates()
    states.receive(head(0, source="operator"), STATE, 0)

    assert states.newest("plant-to-filter") is None


def test_answer_matches_the_request_or_a_later_one() -> None:
    states = NewestLinkStates()
    states.receive(head(0), asked(9, 4), 0)

    assert states.answer("plant-to-filter", "console", 9, 4) == states.newest("plant-to-filter")
    assert states.answer("plant-to-filter", "console", 9, 3) is not None
    assert states.answer("plant-to-filter", "console", 9, 5) is None
    assert states.answer("plant-to-filter", "console", 8, 4) is None
    assert states.answer("plant-to-filter", "dashboard", 9, 4) is None
    assert states.answer("plant-to-operator", "console", 9, 4) is None
