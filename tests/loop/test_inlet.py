"""The way of a message into a node."""

import gc
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol.checksum import with_checksum
from passafe_protocol.codec import encode
from passafe_protocol.errors import ProtocolError, SessionError
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkEvent, OperatorCommand, Received, TopicHealth
from passafe_protocol.topics import COMMAND, INPUT, LINK_STATE, STOP, Topic
from passafe_services.loop.errors import LinkNameError
from passafe_services.loop.inlet import Inlet, inlets_of, pop_inbox
from passafe_services.node import Outgoing

BODY = OperatorCommand((1.0, 2.0), (), enabled=True, device="constant")
MS = 1_000_000


def header(sequence: int, *, source: str = "operator", epoch: int = 7) -> Header:
    return Header(source, epoch, sequence, 0, 0, 0, 0)


class Listener:
    """A node that is never stepped."""

    def __init__(self, name: str, *subscribes: Topic) -> None:
        self.name = name
        self.subscribes = subscribes

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """As ``Node.step``."""
        raise NotImplementedError


def test_message_is_received_once_with_its_arrival_time() -> None:
    inlet = Inlet(COMMAND)
    assert inlet.receive_bytes(5, encode(header(0), BODY)) == ()
    assert inlet.pop_received(9) == [Received(header(0), BODY, 5)]
    assert inlet.pop_received(9) == []


@given(st.binary(max_size=300))
def test_garbage_is_counted_and_reported_without_harm(garbage: bytes) -> None:
    inlet = Inlet(COMMAND)
    assert isinstance(inlet.receive_bytes(0, garbage), ProtocolError)
    assert inlet.receive_bytes(0, encode(header(0), BODY)) == ()
    assert len(inlet.pop_received(0)) == 1
    assert inlet.health == TopicHealth("command", 1, 0, 1)


@pytest.mark.parametrize("garbage", [b"", b"no checksum", with_checksum(b"\xff" * 9)])
def test_refusals_leave_nothing_to_the_collector(garbage: bytes) -> None:
    inlet = Inlet(COMMAND)

    def refuse() -> None:
        outcome = inlet.receive_bytes(0, garbage)  # while this frame holds it
        assert isinstance(outcome, ProtocolError)

    gc.collect()
    refuse()
    assert gc.collect() == 0


def test_duplicates_are_refused_and_reordered_messages_delivered() -> None:
    inlet = Inlet(LINK_STATE)
    for sequence in (0, 2, 2, 1, 6):
        assert inlet.receive(0, header(sequence), BODY) == ()
    assert [message.header.sequence for message in inlet.pop_received(0)] == [0, 2, 1, 6]
    assert inlet.health == TopicHealth("link_state", 4, 3, 1)  # 3, 4 and 5 never came


@pytest.mark.parametrize("epoch", [6, 2**64 - 1])
def test_another_session_is_refused_with_the_reason(epoch: int) -> None:
    inlet = Inlet(INPUT)
    for k in range(5):
        assert inlet.receive(k * MS, header(k, source="filter"), BODY) == ()
        answer = inlet.receive(k * MS, header(90 + k, source="filter", epoch=epoch), BODY)
        assert isinstance(answer, SessionError)
        assert str(answer) == f"input.header.epoch: got {epoch}, allowed 7, the session of filter that is current"
    assert [message.header.sequence for message in inlet.pop_received(9 * MS)] == list(range(5))
    assert inlet.health == TopicHealth("input", 5, 0, 5)


def test_number_out_of_reach_is_refused() -> None:
    inlet = Inlet(INPUT)
    for k in (0, 1):
        inlet.receive(0, header(k, source="filter"), BODY)
    answer = inlet.receive(MS, header(10**8, source="filter"), BODY)
    assert isinstance(answer, SessionError)
    assert str(answer) == "input.header.sequence: got 100000000, allowed at most 69, after what came of filter so far"
    assert inlet.receive(MS, header(2, source="filter"), BODY) == ()


def test_terms_order_sessions_also_behind_a_delay() -> None:
    """An old session's messages that are still on the way when the new one is current have the smaller term."""
    inlet = Inlet(INPUT, MessageLink("filter-to-plant", LinkSettings(delay_s=0.6)))
    sent = [(0, 9, 0), (300, 2, 0), (310, 2, 1), (700, 9, 1)]
    for at_ms, epoch, sequence in sent:
        assert inlet.receive(at_ms * MS, header(sequence, source="filter", epoch=epoch), BODY) == ()
    came = [(each.header.epoch, each.header.sequence, each.term) for each in inlet.pop_received(2_000 * MS)]
    assert came == [(9, 0, 0), (2, 0, 1), (2, 1, 1), (9, 1, 2)]


@pytest.mark.parametrize("topic", [STOP, COMMAND], ids=lambda topic: topic.name)
def test_any_session_is_admitted_beside_another(topic: Topic) -> None:
    inlet = Inlet(topic)
    for sequence, epoch in ((0, 7), (0, 9), (1, 7), (0, 7), (4, 2)):
        assert inlet.receive(0, header(sequence, epoch=epoch), BODY) == ()
    admitted = [(message.header.epoch, message.header.sequence) for message in inlet.pop_received(0)]
    assert admitted == [(7, 0), (9, 0), (7, 1), (2, 4)]


def test_unauthorized_messages_are_refused() -> None:
    inlet = Inlet(COMMAND)
    inlet.receive(0, header(0, source="plant"), BODY)
    assert inlet.pop_received(0) == []
    assert inlet.unauthorized == 1
    assert inlet.health.refused == 1


def test_a_link_delays_by_its_settings() -> None:
    inlet = Inlet(COMMAND, MessageLink("operator-to-filter", LinkSettings(delay_s=0.010)))
    inlet.receive(3 * MS, header(0), BODY)
    assert inlet.pop_received(13 * MS - 1) == []
    assert inlet.pop_received(20 * MS) == [Received(header(0), BODY, 13 * MS)]


def test_dropped_messages_are_reported() -> None:
    inlet = Inlet(COMMAND, MessageLink("operator-to-filter", LinkSettings(loss=1.0)))
    reported = inlet.receive(0, header(4), BODY)
    assert reported == [LinkEvent("operator-to-filter", "dropped", "command", 4, "loss")]
    assert inlet.pop_received(MS) == []
    assert inlet.health.gaps == 0  # the bus lost nothing


def test_an_inbox_is_in_order_of_arrival_over_all_inlets() -> None:
    slow = Inlet(COMMAND, MessageLink("operator-to-filter", LinkSettings(delay_s=0.002)))
    direct = Inlet(COMMAND)
    for sequence in range(3):
        slow.receive(sequence * MS, header(sequence), BODY)
        direct.receive(sequence * MS, header(sequence + 10), BODY)
    inbox = pop_inbox([slow, direct], 3 * MS)
    assert [(m.received_ns // MS, m.header.sequence) for m in inbox] == [
        (0, 10),
        (1, 11),
        (2, 0),
        (2, 12),
        (3, 1),
    ]


def test_a_link_sits_at_its_reader_only() -> None:
    links = {"operator-to-filter": LinkSettings(delay_s=1.0), "filter-to-plant": LinkSettings(delay_s=2.0)}
    (at_filter,) = inlets_of(Listener("filter", COMMAND), links)
    at_plant, beside = inlets_of(Listener("plant", INPUT, COMMAND), links)
    assert at_filter.link is not None
    assert at_filter.link.settings.delay_s == 1.0
    assert at_plant.link is not None
    assert at_plant.link.settings.delay_s == 2.0
    assert beside.link is None


def test_a_link_without_settings_lets_everything_through_at_once() -> None:
    (inlet,) = inlets_of(Listener("filter", COMMAND), {})
    inlet.receive(5, header(0), BODY)
    assert inlet.pop_received(5) == [Received(header(0), BODY, 5)]


def test_an_unknown_link_is_refused() -> None:
    with pytest.raises(LinkNameError, match="got 'filter-to-moon', allowed operator-to-filter, ") as caught:
        inlets_of(Listener("filter", COMMAND), {"filter-to-moon": LinkSettings()})
    assert caught.value.got == "filter-to-moon"
