"""Output of a link, its times and its reproducibility; statistics are in a file of their own."""

from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.link import Link
from passafe_protocol.link_effect import (
    CORRUPTED,
    DROPPED_BY_LOSS,
    DROPPED_BY_OUTAGE,
    DROPPED_BY_QUEUE,
    DUPLICATED,
    NO_EFFECT,
)
from passafe_protocol.link_settings import DISTRIBUTIONS, MAX_DELAY_S, LinkSettings

S = 1_000_000_000
MS = 1_000_000
COUNT = 20_000

share = st.sampled_from([0.0, 0.0, 0.2, 0.5, 1.0])


@st.composite
def any_settings(draw: st.DrawFn) -> LinkSettings:
    """Draw settings with any combination of effects."""
    distribution = draw(st.sampled_from(DISTRIBUTIONS))
    by_table = distribution == "histogram"
    limit = draw(st.sampled_from(["none", "rate", "trace"]))
    edges = sorted(draw(st.sets(st.sampled_from([0.0, 0.01, 0.1, 0.3, 0.5, 2.0]), max_size=4)))
    return LinkSettings(
        delay_s=draw(st.sampled_from([0.0, 0.02, MAX_DELAY_S])),
        jitter_s=0.0 if by_table else draw(st.sampled_from([0.0, 0.01, 1.0])),
        distribution=distribution,
        quantiles_s=(0.0, 0.01, 0.01, 0.2) if by_table else (),
        correlation=draw(st.sampled_from([0.0, 0.5])),
        reorder=draw(st.booleans()),
        loss=draw(share),
        burst_enter=draw(share),
        burst_leave=draw(share),
        burst_loss_good=draw(share),
        duplicate=draw(share),
        corrupt=draw(share),
        rate_hz=draw(st.sampled_from([10.0, 100.0])) if limit == "rate" else 0.0,
        queue=draw(st.sampled_from([1, 3, 1000])),
        outages_s=tuple(zip(edges[::2], edges[1::2], strict=False)),
        trace_s=(0.0, 0.003, 0.003, 0.1) if limit == "trace" else (),
        seed=draw(st.integers(0, 5)),
    )


def outcome(settings: LinkSettings, count: int = COUNT, name: str = "a-to-b") -> list[int | None]:
    """Delay in ns of each of ``count`` messages put in at time 0, ``None`` for those that were dropped."""
    link: Link[int] = Link(name, settings)
    delays: list[int | None] = [None] * count
    dropped = {i for i in range(count) if link.put(0, i) == DROPPED_BY_LOSS}
    for arrival_ns, i in link.pop_arrived(2 * 10 * S):
        delays[i] = arrival_ns
    assert dropped == {i for i, delay in enumerate(delays) if delay is None}
    return delays


def arrived(delays: list[int | None]) -> list[int]:
    return [delay for delay in delays if delay is not None]


def test_unimpaired_link_delivers_at_once_and_in_order() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings())

    assert [link.put(5, item) for item in "abc"] == [NO_EFFECT] * 3
    assert link.pop_arrived(4) == []
    assert link.pop_arrived(5) == [(5, "a"), (5, "b"), (5, "c")]
    assert link.pop_arrived(6) == []


def test_constant_delay_is_exact() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings(delay_s=0.2))
    link.put(7, "a")

    assert link.pop_arrived(200 * MS + 6) == []
    assert link.pop_arrived(200 * MS + 7) == [(200 * MS + 7, "a")]


def test_items_need_not_be_comparable() -> None:
    link: Link[dict[str, int]] = Link("a-to-b", LinkSettings())
    link.put(0, {"b": 1})
    link.put(0, {"a": 2})

    assert [item for _, item in link.pop_arrived(0)] == [{"b": 1}, {"a": 2}]


@pytest.mark.parametrize(("loss", "lost"), [(0.0, 0), (1.0, 1000)])
def test_no_loss_and_total_loss_are_exact(loss: float, lost: int) -> None:
    assert outcome(LinkSettings(loss=loss), count=1000).count(None) == lost


def test_the_same_seed_repeats_itself() -> None:
    settings = LinkSettings(delay_s=0.1, jitter_s=0.05, loss=0.3, seed=11)

    assert outcome(settings, 500) == outcome(settings, 500)


def test_another_seed_or_another_name_is_another_sequence() -> None:
    settings = LinkSettings(delay_s=0.1, jitter_s=0.05, loss=0.3, seed=11)
    other_seed = LinkSettings(delay_s=0.1, jitter_s=0.05, loss=0.3, seed=12)

    assert outcome(settings, 500) != outcome(other_seed, 500)
    assert outcome(settings, 500) != outcome(settings, 500, name="b-to-a")


def test_a_logged_seed_gives_the_same_delays_in_years_to_come() -> None:
    delays = outcome(LinkSettings(delay_s=0.1, jitter_s=0.1, loss=0.4, seed=1), 6)

    assert delays == [179_129_636, 31_904_739, None, None, 89_385_640, 151_914_555]


def test_changing_one_setting_leaves_the_others_alone() -> None:
    few = outcome(LinkSettings(jitter_s=0.01, delay_s=0.1, loss=0.1), 2000)
    many = outcome(LinkSettings(jitter_s=0.01, delay_s=0.1, loss=0.6), 2000)
    steady = outcome(LinkSettings(jitter_s=0.0, delay_s=0.3, loss=0.6), 2000)

    assert all(a == b for a, b in zip(few, many, strict=True) if b is not None)
    assert [delay is None for delay in many] == [delay is None for delay in steady]


def test_reconfiguration_keeps_arrival_times_in_flight() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings(delay_s=1.0))
    link.put(0, "slow")
    link.reconfigure(LinkSettings(delay_s=0.1))
    link.put(0, "fast")

    assert link.settings == LinkSettings(delay_s=0.1)
    assert link.pop_arrived(2 * S) == [(100 * MS, "fast"), (S, "slow")]


def test_reconfiguration_keeps_generators_for_the_same_seed() -> None:
    settings = LinkSettings(delay_s=0.1, jitter_s=0.05, loss=0.5, seed=1)
    expected = outcome(settings, 200)
    link: Link[int] = Link("a-to-b", settings)
    lost = [link.put(0, i) == DROPPED_BY_LOSS for i in range(100)]
    link.reconfigure(replace(settings, duplicate=1.0, corrupt=0.5, reorder=False))  # another way of putting
    lost += [DROPPED_BY_LOSS[0] in link.put(0, i) for i in range(100, 150)]
    link.reconfigure(settings)
    lost += [link.put(0, i) == DROPPED_BY_LOSS for i in range(150, 200)]
    link.reconfigure(replace(settings, seed=2))
    link.reconfigure(settings)
    from_the_start = [link.put(0, i) == DROPPED_BY_LOSS for i in range(200)]

    assert lost == [delay is None for delay in expected]
    assert from_the_start == lost


def test_without_reordering_messages_in_flight_stay_in_order_too() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(delay_s=0.5, jitter_s=0.5))
    for i in range(50):
        link.put(i * MS, i)
    in_flight = link.counts.in_flight
    link.reconfigure(LinkSettings(delay_s=0.01, jitter_s=0.01, reorder=False, duplicate=0.3))
    for i in range(50, 100):
        link.put(i * MS, i)
    out = link.pop_arrived(20 * S)

    assert in_flight == 50
    assert sorted(i for _, i in out[:50]) == list(range(50))
    assert [i for _, i in out[50:]] == sorted(i for _, i in out[50:])


def test_rate_spaces_messages_and_drops_at_a_full_queue() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(delay_s=1.0, rate_hz=100.0, queue=3))

    assert [link.put(0, i) for i in range(5)] == [NO_EFFECT] * 3 + [DROPPED_BY_QUEUE] * 2
    assert link.put(10 * MS, 5) == NO_EFFECT  # one is through
    assert link.put(S, 6) == NO_EFFECT
    assert link.pop_arrived(5 * S) == [(S + n * 10 * MS, i) for n, i in ((1, 0), (2, 1), (3, 2), (4, 5))] + [
        (2010 * MS, 6)
    ]


def test_a_slower_rate_lets_those_that_wait_go_first() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(rate_hz=1.0))
    for i in range(3):
        link.put(0, i)
    link.reconfigure(LinkSettings(rate_hz=1000.0, queue=4))
    assert [link.put(0, i) for i in (3, 4)] == [NO_EFFECT, DROPPED_BY_QUEUE]
    link.reconfigure(LinkSettings())
    link.put(0, 5)

    assert [i for _, i in link.pop_arrived(5 * S)] == [5, 0, 1, 2, 3]


def test_trace_passes_one_message_per_time_and_repeats() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(trace_s=(0.0, 0.002, 0.002, 0.010)))
    start = 7 * S
    for i in range(6):
        link.put(start, i)
    link.put(start + 25 * MS, 6)  # opportunities of before are gone
    link.put(start + 25 * MS, 7)

    times = [(arrival_ns - start) / MS for arrival_ns, _ in link.pop_arrived(start + S)]
    assert times == [0, 2, 2, 10, 10, 12, 30, 30]


def test_message_at_the_last_opportunity_of_a_round_uses_it() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(trace_s=(0.004, 0.010)))
    for i, now_ns in enumerate((S, S + 10 * MS, S + 20 * MS)):
        link.put(now_ns, i)

    assert [(arrival_ns - S) / MS for arrival_ns, _ in link.pop_arrived(2 * S)] == [4, 10, 20]


def test_a_trace_of_one_time_is_a_rate() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(trace_s=(0.001,)))
    for i in range(5):
        link.put(S, i)

    assert [arrival_ns - S for arrival_ns, _ in link.pop_arrived(2 * S)] == [MS * n for n in range(1, 6)]


def test_outages_count_from_the_first_message_under_them() -> None:
    link: Link[int] = Link("a-to-b", LinkSettings(outages_s=((0.010, 0.020), (0.030, 0.031))))
    start = 3 * S
    cut = [i for i in range(40) if link.put(start + i * MS, i) == DROPPED_BY_OUTAGE]
    link.reconfigure(LinkSettings(outages_s=((0.0, 0.002),), delay_s=0.1))
    cut_again = [i for i in range(5) if link.put(start + S + i * MS, i) == DROPPED_BY_OUTAGE]

    assert cut == [*range(10, 20), 30]
    assert cut_again == [0, 1]
    assert link.counts.dropped_outage == 13


def test_other_settings_leave_outages_and_trace_where_they_are() -> None:
    settings = LinkSettings(outages_s=((0.010, 0.020),), trace_s=(0.005, 0.100))
    link: Link[int] = Link("a-to-b", settings)
    link.put(0, 0)
    link.reconfigure(replace(settings, loss=1.0))

    assert link.put(15 * MS, 1) == DROPPED_BY_OUTAGE
    link.reconfigure(replace(settings, queue=2))
    link.put(50 * MS, 2)
    assert link.pop_arrived(S) == [(5 * MS, 0), (100 * MS, 2)]


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
