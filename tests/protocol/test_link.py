"""Delay, jitter and loss match their definitions; order and randomness are reproducible."""

from itertools import pairwise
from math import inf, nan, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import LinkSettingsError
from protocol.link import DROPPED, MAX_DELAY_S, Link, LinkSettings

S = 1_000_000_000
MS = 1_000_000
COUNT = 20_000
SIGMAS = 4.0  # bound of the statistical tests; the seeds are fixed, so that they pass always or never

settings_strategy = st.builds(
    LinkSettings,
    delay_s=st.floats(0, MAX_DELAY_S),
    jitter_s=st.floats(0, MAX_DELAY_S),
    loss=st.floats(0, 1),
    seed=st.integers(0, 2**64 - 1),
)


def outcome(settings: LinkSettings, count: int = COUNT, name: str = "a-to-b") -> list[int | None]:
    """Delay in ns of each of ``count`` messages put in at time 0, ``None`` for those that were dropped."""
    link: Link[int] = Link(name, settings)
    delays: list[int | None] = [None] * count
    dropped = {i for i in range(count) if link.put(0, i) == DROPPED}
    for arrival_ns, i in link.take(2 * 10 * S):
        delays[i] = arrival_ns
    assert dropped == {i for i, delay in enumerate(delays) if delay is None}
    return delays


def arrived(delays: list[int | None]) -> list[int]:
    return [delay for delay in delays if delay is not None]


def test_without_impairment_everything_is_there_at_once_and_in_order() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings())

    assert [link.put(5, item) for item in "abc"] == [None, None, None]
    assert link.take(4) == []
    assert link.take(5) == [(5, "a"), (5, "b"), (5, "c")]
    assert link.take(6) == []


def test_constant_delay_is_exact() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings(delay_s=0.2))
    link.put(7, "a")

    assert link.take(200 * MS + 6) == []
    assert link.take(200 * MS + 7) == [(200 * MS + 7, "a")]


def test_items_need_not_be_comparable() -> None:
    link: Link[dict[str, int]] = Link("a-to-b", LinkSettings())
    link.put(0, {"b": 1})
    link.put(0, {"a": 2})

    assert [item for _, item in link.take(0)] == [{"b": 1}, {"a": 2}]


def test_jitter_is_uniform_about_the_delay() -> None:
    delay, jitter = 100 * MS, 40 * MS
    delays = arrived(outcome(LinkSettings(delay_s=0.1, jitter_s=0.04, seed=3)))

    assert len(delays) == COUNT
    assert all(delay - jitter <= d <= delay + jitter for d in delays)
    # The uniform distribution of half width J has mean 0 and variance J²/3.
    assert abs(sum(delays) / COUNT - delay) < SIGMAS * jitter / sqrt(3 * COUNT)
    for tenth in range(10):
        low = delay - jitter + tenth * jitter / 5
        inside = sum(low <= d < low + jitter / 5 for d in delays)
        assert abs(inside - 0.1 * COUNT) < SIGMAS * sqrt(COUNT * 0.1 * 0.9)


def test_delay_never_falls_below_zero() -> None:
    delays = arrived(outcome(LinkSettings(delay_s=0.01, jitter_s=0.04, seed=3)))
    at_once = 3 / 8  # share of ±40 ms that lies below −10 ms

    assert min(delays) == 0
    assert abs(delays.count(0) - at_once * COUNT) < SIGMAS * sqrt(COUNT * at_once * (1 - at_once))


@pytest.mark.parametrize("loss", [0.02, 0.2, 0.5, 0.9])
def test_loss_is_the_share_that_is_lost(loss: float) -> None:
    lost = outcome(LinkSettings(loss=loss, seed=5)).count(None)

    assert abs(lost - loss * COUNT) < SIGMAS * sqrt(COUNT * loss * (1 - loss))


def test_losses_are_independent() -> None:
    lost = [delay is None for delay in outcome(LinkSettings(loss=0.3, seed=5))]
    twice = sum(a and b for a, b in pairwise(lost))

    # Pairs that overlap are correlated: variance per pair is p²(1 − p²) + 2(p³ − p⁴).
    variance = 0.3**2 * (1 - 0.3**2) + 2 * (0.3**3 - 0.3**4)
    assert abs(twice - 0.09 * COUNT) < SIGMAS * sqrt(COUNT * variance)


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

    assert delays == [62_850_554, 93_690_917, 192_322_804, 152_594_647, 61_549_549, None]


def test_changing_one_setting_leaves_the_others_alone() -> None:
    few = outcome(LinkSettings(jitter_s=0.01, delay_s=0.1, loss=0.1), 2000)
    many = outcome(LinkSettings(jitter_s=0.01, delay_s=0.1, loss=0.6), 2000)
    steady = outcome(LinkSettings(jitter_s=0.0, delay_s=0.3, loss=0.6), 2000)

    assert all(a == b for a, b in zip(few, many, strict=True) if b is not None)
    assert [delay is None for delay in many] == [delay is None for delay in steady]


def test_reconfigured_link_lets_messages_under_way_keep_their_time() -> None:
    link: Link[str] = Link("a-to-b", LinkSettings(delay_s=1.0))
    link.put(0, "slow")
    link.reconfigure(LinkSettings(delay_s=0.1))
    link.put(0, "fast")

    assert link.settings == LinkSettings(delay_s=0.1)
    assert link.take(2 * S) == [(100 * MS, "fast"), (S, "slow")]


def test_reconfigured_link_goes_on_with_its_sequence_unless_the_seed_changes() -> None:
    lossy = LinkSettings(loss=0.5, seed=1)
    expected = [delay is None for delay in outcome(lossy, 200)]
    link: Link[int] = Link("a-to-b", LinkSettings(seed=1))
    for i in range(100):
        link.put(0, i)
    link.reconfigure(lossy)
    second_half = [link.put(0, i) == DROPPED for i in range(100)]
    link.reconfigure(LinkSettings(loss=0.5, seed=2))
    link.reconfigure(lossy)
    from_the_start = [link.put(0, i) == DROPPED for i in range(200)]

    assert second_half == expected[100:]
    assert from_the_start == expected


@settings(deadline=None)
@given(settings_strategy, st.lists(st.integers(0, 50 * MS), max_size=60), st.integers(1, 20))
def test_each_message_comes_out_once_in_order_and_never_early(
    settings: LinkSettings, pauses: list[int], looks: int
) -> None:
    link: Link[tuple[int, int]] = Link("a-to-b", settings)
    now_ns, kept, out = 0, [], []
    for i, pause in enumerate(pauses):
        now_ns += pause
        if link.put(now_ns, (i, now_ns)) is None:
            kept.append(i)
        if i % looks == 0:
            taken = link.take(now_ns)
            assert all(arrival_ns <= now_ns for arrival_ns, _ in taken)
            out.append(taken)
    out.append(link.take(now_ns + 20 * S))

    assert sorted(i for taken in out for _, (i, _) in taken) == kept
    for taken in out:
        assert taken == sorted(taken)  # by arrival, then by number of insertion
        assert all(arrival_ns >= put_ns for arrival_ns, (_, put_ns) in taken)


@pytest.mark.parametrize(
    ("field", "got"),
    [
        ("delay_s", -1e-9),
        ("delay_s", MAX_DELAY_S * 1.001),
        ("delay_s", nan),
        ("delay_s", inf),
        ("delay_s", "0.1"),
        ("delay_s", True),
        ("jitter_s", -0.1),
        ("jitter_s", nan),
        ("jitter_s", None),
        ("loss", -0.1),
        ("loss", 1.0001),
        ("loss", nan),
        ("seed", -1),
        ("seed", 2**64),
        ("seed", 1.0),
        ("seed", False),
    ],
)
def test_setting_outside_its_range_is_refused(field: str, got: object) -> None:
    with pytest.raises(LinkSettingsError) as caught:
        LinkSettings(**{field: got})

    assert caught.value.field == field
    assert caught.value.got is got


@pytest.mark.parametrize("field", ["delay_s", "jitter_s"])
def test_limits_are_allowed(field: str) -> None:
    assert getattr(LinkSettings(**{field: MAX_DELAY_S}), field) == MAX_DELAY_S
    assert getattr(LinkSettings(**{field: 0}), field) == 0
