"""Links with a rate, a trace or outages: what waits, what is dropped."""

from dataclasses import replace

from link_outcomes import MS, S
from passafe_protocol.link import Link
from passafe_protocol.link_effect import (
    DROPPED_BY_OUTAGE,
    DROPPED_BY_QUEUE,
    NO_EFFECT,
)
from passafe_protocol.link_settings import LinkSettings


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
