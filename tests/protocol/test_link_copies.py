"""Copies, damage and losses of a link: every message is accounted for."""

from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st
from link_outcomes import MS, S, any_settings
from passafe_protocol.link import Link
from passafe_protocol.link_effect import (
    CORRUPTED,
    DROPPED_BY_LOSS,
    DROPPED_BY_OUTAGE,
    DUPLICATED,
)
from passafe_protocol.link_settings import LinkSettings


def test_a_copy_comes_out_with_a_delay_of_its_own() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(delay_s=0.1, jitter_s=0.05, duplicate=1.0))
    assert [link.put(0, i) for i in range(100)] == [DUPLICATED] * 100
    out = link.pop_arrived(S)

    assert sorted(i for _, i in out) == sorted(2 * list(range(100)))
    assert len({arrival_ns for arrival_ns, _ in out}) == 200


def test_a_lost_message_has_no_copy() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(loss=1.0, duplicate=1.0, corrupt=1.0))

    assert link.put(0, 1) == DROPPED_BY_LOSS
    assert link.counts.duplicated == link.counts.corrupted == 0


def test_corrupted_item_is_damaged_at_the_drawn_position() -> None:
    settings = LinkSettings(corrupt=0.5, duplicate=0.5)

    def outcomes() -> list[object]:
        link: Link[object] = Link("a-to-b", settings, lambda item, place: (item, place))
        reported = [link.put(i, i) for i in range(200)]
        out = link.pop_arrived(S)
        damaged = [item for _, item in out if isinstance(item, tuple)]
        assert len(damaged) == sum(effects.count(CORRUPTED[0]) for effects in reported) == link.counts.corrupted
        return out

    places = [item[1] for _, item in outcomes() if isinstance(item, tuple)]
    assert outcomes() == outcomes()
    assert len(places) > 100
    assert 0 <= min(places) < 0.1
    assert 0.9 < max(places) < 1


def test_corrupted_item_without_damage_function_is_unchanged() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings(corrupt=1.0))

    assert link.put(0, "a") == CORRUPTED
    assert link.pop_arrived(0) == [(0, "a")]


@settings(deadline=None)
@given(
    st.lists(any_settings(), min_size=1, max_size=3),
    st.lists(st.integers(0, 50 * MS), max_size=60),
    st.integers(1, 20),
    st.integers(5, 60),
)
def test_every_message_is_accounted_for_at_any_moment(
    chosen: list[LinkSettings], pauses: list[int], looks: int, changes: int
) -> None:
    link: Link[tuple[int, int]] = Link("a-to-b", chosen[0])
    now_ns, reported, out = 0, [], []
    for i, pause in enumerate(pauses):
        now_ns += pause
        if i % changes == 0:
            link.reconfigure(chosen[i // changes % len(chosen)])
        reported += link.put(now_ns, (i, now_ns))
        if i % looks == 0:
            out += link.pop_arrived(now_ns)
            assert all(arrival_ns <= now_ns for arrival_ns, _ in out)
        counts = link.counts
        assert counts.entered == i + 1
        assert counts.entered + counts.duplicated == counts.delivered + counts.dropped + counts.in_flight
        assert counts.delivered == len(out)
    everything = out + link.pop_arrived(now_ns + 10**15)
    counts = link.counts

    assert counts.in_flight == 0
    assert all(arrival_ns >= put_ns for arrival_ns, (_, put_ns) in everything)
    assert reported.count(DROPPED_BY_LOSS[0]) == counts.dropped_loss
    assert reported.count(DROPPED_BY_OUTAGE[0]) == counts.dropped_outage
    assert sum(effect.effect == "dropped" for effect in reported) == counts.dropped
    assert sum(effect.effect == "duplicated" for effect in reported) == counts.duplicated
    assert sum(effect.effect == "corrupted" for effect in reported) == counts.corrupted
    copies = len(everything) - len({i for _, (i, _) in everything})
    assert copies == counts.duplicated


@settings(deadline=None)
@given(any_settings(), st.lists(st.integers(0, 50 * MS), max_size=60), st.integers(1, 20))
def test_arrivals_are_ordered_and_without_reordering_as_put(
    chosen: LinkSettings, pauses: list[int], looks: int
) -> None:
    link: Link[int] = Link("a-to-b", chosen)
    now_ns, out = 0, []
    for i, pause in enumerate(pauses):
        now_ns += pause
        link.put(now_ns, i)
        if i % looks == 0:
            out.append(link.pop_arrived(now_ns))
    out.append(link.pop_arrived(now_ns + 10**15))

    for taken in out:
        assert [arrival_ns for arrival_ns, _ in taken] == sorted(arrival_ns for arrival_ns, _ in taken)
    if not chosen.reorder:
        assert all(a <= b for a, b in pairwise(i for taken in out for _, i in taken))
