"""A link of messages: damage is done to bytes and classified by the decoder, and all of it is reported."""

from dataclasses import replace

import passafe_protocol.message_link
import pytest
from passafe_protocol.codec import decode, encode
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import (
    Header,
    LinkConfig,
    LinkEvent,
    LinkSource,
    Message,
    PlantInput,
    PlantState,
    Received,
)
from passafe_protocol.topics import COMMAND, INPUT, TOPIC_OF_BODY

MS = 1_000_000
FULL = LinkSettings(
    delay_s=0.1,
    distribution="histogram",
    quantiles_s=(0.0, 0.5),
    correlation=0.25,
    reorder=False,
    loss=0.125,
    burst_enter=0.5,
    burst_leave=0.25,
    burst_loss_good=0.0625,
    burst_loss_bad=0.75,
    duplicate=0.1,
    corrupt=0.2,
    queue=7,
    outages_s=((1.0, 2.0), (3.0, 4.0)),
    trace_s=(0.5, 1.0),
    seed=2**64 - 1,
)


def head(sequence: int, epoch: int = 1) -> Header:
    return Header("filter", epoch, sequence, 0, 0, 0, 0)


def an_input(tick: int) -> PlantInput:
    return PlantInput(tick, (0.5, -0.5), 0, 0)


def test_settings_come_back_from_the_wire_as_they_were() -> None:
    assert settings_of(parameters_of(FULL), FULL.trace_s) == FULL
    assert settings_of(parameters_of(FULL)) == replace(FULL, trace_s=())


def test_messages_come_out_with_their_time() -> None:
    link = MessageLink("filter-to-plant", LinkSettings(delay_s=0.01))
    link.put(0, (head(0), an_input(1), 0))

    assert link.pop_received(9 * MS) == []
    assert link.pop_received(20 * MS) == [Received(head(0), an_input(1), 10 * MS)]


def test_corrupted_message_has_one_flipped_bit_and_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[bytes] = []
    monkeypatch.setattr(
        passafe_protocol.message_link, "decode", lambda topic, data: seen.append(data) or decode(topic, data)
    )
    link = MessageLink("filter-to-plant", LinkSettings(corrupt=0.5, seed=3))
    reported = [link.put(0, (head(i), an_input(i), 0)) for i in range(400)]
    came = link.pop_received(0)

    assert len(seen) == link.counts.corrupted == link.refused_corrupted == 400 - len(came)
    assert [received.header.sequence for received in came] == [i for i, effects in enumerate(reported) if not effects]
    bits = set()
    for i, data in zip([i for i, effects in enumerate(reported) if effects], seen, strict=True):
        whole = encode(head(i), an_input(i))
        differing = int.from_bytes(data, "big") ^ int.from_bytes(whole, "big")
        assert len(data) == len(whole)
        assert differing.bit_count() == 1
        bits.add(differing)
    assert len(bits) > 100  # all over the message


def test_what_the_decoder_lets_pass_is_what_comes_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_protocol.message_link, "decode", lambda _topic, _data: (head(7), an_input(99)))
    link = MessageLink("filter-to-plant", LinkSettings(corrupt=1.0))
    link.put(0, (head(7), an_input(1), 0))

    assert link.pop_received(0) == [Received(head(7), an_input(99), 0)]
    assert link.refused_corrupted == 0


def test_nothing_is_encoded_unless_it_is_corrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    encoded: list[Header] = []
    monkeypatch.setattr(
        passafe_protocol.message_link, "encode", lambda header, body: encoded.append(header) or encode(header, body)
    )
    link = MessageLink("filter-to-plant", LinkSettings(corrupt=0.1, duplicate=0.3))
    for i in range(200):
        link.put(0, (head(i), an_input(i), 0))

    assert len(encoded) == link.counts.corrupted > 0


def test_a_copy_is_refused_wherever_it_comes() -> None:
    link = MessageLink("filter-to-plant", LinkSettings(delay_s=0.1, jitter_s=0.1, duplicate=0.5))
    for i in range(100):
        link.put(i * MS, (head(i), an_input(i), 0))
    came = [received.header.sequence for received in link.pop_received(10**12)]

    assert sorted(came) == list(range(100))
    assert link.refused_duplicate == link.counts.duplicated > 0
    assert link.counts.delivered == 100 + link.counts.duplicated


def test_only_links_that_ever_damaged_messages_check_them() -> None:
    link = MessageLink("filter-to-plant", LinkSettings(delay_s=1.0))
    link.reconfigure(LinkSettings(duplicate=1.0, delay_s=1.0))
    link.put(0, (head(0), an_input(0), 0))
    link.reconfigure(LinkSettings(delay_s=1.0))

    assert len(link.pop_received(10**10)) == 1
    assert link.refused_duplicate == 1


def test_copies_are_known_by_session_and_terms_kept() -> None:
    link = MessageLink("filter-to-plant", LinkSettings(duplicate=1.0))
    for term, epoch in ((0, 9), (1, 2), (2, 9)):
        link.put(term * MS, (head(term, epoch), an_input(term), term))
    came = [(received.header.epoch, received.term) for received in link.pop_received(10 * MS)]

    assert came == [(9, 0), (2, 1), (9, 2)]
    assert link.refused_duplicate == 3


def test_effects_are_reported_as_events() -> None:
    link = MessageLink("filter-to-plant", LinkSettings(corrupt=1.0, duplicate=1.0))
    effects = link.put(0, (head(5), an_input(0), 0))

    assert link.events(head(5), effects) == [
        LinkEvent("filter-to-plant", effect, "input", 5) for effect in ("corrupted", "duplicated", "corrupted")
    ]
    link.reconfigure(LinkSettings(loss=1.0))
    assert link.events(head(6), link.put(0, (head(6), an_input(0), 0))) == [
        LinkEvent("filter-to-plant", "dropped", "input", 6, "loss")
    ]


def test_state_has_settings_counts_and_requester(header: Header) -> None:
    link = MessageLink("operator-to-filter", FULL)
    wanted = LinkConfig("operator-to-filter", parameters_of(replace(FULL, loss=0.0, trace_s=())))
    before = link.state("start", ())
    link.configure(header, wanted)
    after = link.state("requested", (LinkSource("operator", 1, 0, 9, 10),))

    assert (before.link, before.topic, before.trigger) == ("operator-to-filter", COMMAND.name, "start")
    assert before.parameters == parameters_of(FULL)
    assert before.trace_opportunities == after.trace_opportunities == 2
    assert (before.config_source, before.config_epoch, before.config_sequence) == ("", 0, 0)
    assert after.parameters == wanted.parameters
    assert (after.config_source, after.config_epoch, after.config_sequence) == ("plant", header.epoch, 300)
    assert after.refusal == ""
    assert after.sources == (LinkSource("operator", 1, 0, 9, 10),)
    assert decode(TOPIC_OF_BODY[type(after)], encode(header, after)) == (header, after)


def test_contradictory_settings_are_refused_with_a_reason(header: Header) -> None:
    link = MessageLink("operator-to-filter", FULL)
    link.configure(header, LinkConfig("operator-to-filter", parameters_of(replace(FULL, trace_s=(), rate_hz=5.0))))
    refused = link.state("requested", ())
    link.configure(header, LinkConfig("operator-to-filter", parameters_of(replace(FULL, trace_s=()))))

    assert refused.parameters == parameters_of(FULL)
    assert refused.refusal == "link rate_hz: got 5.0, allowed 0 if there is a trace"
    assert link.state("requested", ()).refusal == ""


def test_counts_of_the_state_are_those_of_the_link(body_of: dict[type, Message]) -> None:
    link = MessageLink("plant-to-filter", LinkSettings(rate_hz=10.0, queue=2))
    for i in range(5):
        link.put(0, (head(i), body_of[PlantState], 0))
    link.count_passed(3)
    link.pop_received(100 * MS)
    state = link.state("period", ())

    assert (state.entered, state.delivered, state.dropped_queue, state.in_flight) == (8, 4, 3, 1)
    assert INPUT.links == {"plant": "filter-to-plant"}
