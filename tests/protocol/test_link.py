"""Output of a link, its times and its reproducibility; statistics are in a file of their own."""

from dataclasses import replace

import pytest
from link_outcomes import MS, S, outcome
from passafe_protocol.link import Link
from passafe_protocol.link_effect import (
    DROPPED_BY_LOSS,
    NO_EFFECT,
)
from passafe_protocol.link_settings import LinkSettings


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
