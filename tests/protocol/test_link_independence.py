"""One setting of a link leaves the effects of others as they are."""

from dataclasses import replace

import pytest
from link_outcomes import MS
from passafe_protocol.link import Link
from passafe_protocol.link_effect import (
    DROPPED_BY_LOSS,
)
from passafe_protocol.link_settings import LinkSettings

Fate = tuple[bool, dict[str, tuple[int, object]]]


def fates(settings: LinkSettings) -> list[Fate]:
    """For each of 300 messages: whether it was lost, and arrival and item of the message and of its copy."""
    link: Link[object] = Link("a-to-b", settings, lambda _, place: place)
    lost = [DROPPED_BY_LOSS[0] in link.put(i * MS, "whole") for i in range(300)]
    sent = {number: (arrival_ns, item) for arrival_ns, number, item in link._in_flight}
    places = ((i + 1, i + 1.5) for i in range(300))
    return [
        (gone, {name: sent[at] for name, at in zip(("message", "copy"), place, strict=True) if at in sent})
        for gone, place in zip(lost, places, strict=True)
    ]


EVERYTHING = LinkSettings(
    delay_s=0.1, jitter_s=0.05, loss=0.2, burst_enter=0.1, burst_leave=0.5, duplicate=0.3, corrupt=0.3
)


@pytest.mark.parametrize(
    "off", [{"loss": 0.0}, {"burst_enter": 0.0}, {"loss": 0.0, "burst_enter": 0.0, "outages_s": ((0.1, 0.2),)}]
)
def test_what_is_lost_changes_nothing_about_the_others(off: dict[str, object]) -> None:
    before, after = fates(EVERYTHING), fates(replace(EVERYTHING, **off))

    both = [(a["message"], b["message"]) for (_, a), (_, b) in zip(before, after, strict=True) if a and b]
    assert len(both) > 100
    assert [a for a, _ in both] == [b for _, b in both]
    assert ["copy" in a for _, a in before if a] != ["copy" in a for _, a in after if a]  # others survive


def test_bursts_come_on_top_of_the_same_independent_losses() -> None:
    both, independent = fates(EVERYTHING), fates(replace(EVERYTHING, burst_enter=0.0))

    assert all(lost for (lost, _), (alone, _) in zip(both, independent, strict=True) if alone)
    assert sum(lost for lost, _ in both) > sum(lost for lost, _ in independent)


def test_without_duplication_messages_fare_as_before() -> None:
    before, after = fates(EVERYTHING), fates(replace(EVERYTHING, duplicate=0.0))

    assert [lost for lost, _ in before] == [lost for lost, _ in after]
    assert [a.get("message") for _, a in before] == [a.get("message") for _, a in after]
    assert any("copy" in a for _, a in before)
    assert not any("copy" in a for _, a in after)


def test_without_corruption_messages_arrive_as_before() -> None:
    before, after = fates(EVERYTHING), fates(replace(EVERYTHING, corrupt=0.0))

    assert [lost for lost, _ in before] == [lost for lost, _ in after]
    assert [a["message"][0] for _, a in before if a] == [a["message"][0] for _, a in after if a]
    assert ["copy" in a for _, a in before] == ["copy" in a for _, a in after]
    assert {item for _, a in after for _, item in a.values()} == {"whole"}


def test_another_delay_changes_nothing_about_what_happens() -> None:
    before = fates(EVERYTHING)
    after = fates(replace(EVERYTHING, delay_s=0.3, jitter_s=0.1, distribution="pareto", correlation=0.5))

    assert [lost for lost, _ in before] == [lost for lost, _ in after]
    assert ["copy" in a for _, a in before] == ["copy" in a for _, a in after]
    assert [a["message"][1] for _, a in before if a] == [a["message"][1] for _, a in after if a]
