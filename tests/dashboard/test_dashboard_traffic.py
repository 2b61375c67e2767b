import pytest
from closed_form import MS, header
from passafe_dashboard.traffic import Traffic
from passafe_protocol.topics import HEALTH, SCENARIO, TICK


def test_rate_is_messages_a_second() -> None:
    traffic = Traffic(TICK, "filter")
    for k in range(3000):
        traffic.take(header("filter", k), k * MS)
    assert traffic.view(2999 * MS).rate_hz == pytest.approx(1000.0)


def test_rate_of_a_silent_topic_goes_to_zero() -> None:
    traffic = Traffic(TICK, "filter")
    for k in range(3000):
        traffic.take(header("filter", k), k * MS)
    assert traffic.view(6999 * MS).rate_hz == pytest.approx(0.25)


def test_missing_repeated_and_foreign_messages_are_counted() -> None:
    traffic = Traffic(TICK, "filter")
    taken = [
        traffic.take(header("filter", sequence, epoch=epoch), 0)
        for sequence, epoch in ((0, 5), (3, 5), (1, 5), (3, 5), (4, 4))
    ]
    assert taken == [True, True, True, False, False]
    view = traffic.view(0)
    assert (view.received, view.gaps, view.refused) == (3, 1, 2)


def test_late_is_judged_by_the_topic_s_deadline_and_the_moment_of_looking() -> None:
    traffic = Traffic(HEALTH, "plant")
    traffic.take(header("plant", 0), 0)
    assert not traffic.view(3_050 * MS).late
    assert traffic.view(3_150 * MS).late
    assert traffic.view(3_150 * MS).age_s == pytest.approx(3.15)


def test_a_topic_without_deadline_is_never_late() -> None:
    traffic = Traffic(SCENARIO, "filter")
    traffic.take(header("filter", 0), 0)
    assert not traffic.view(10**15).late
