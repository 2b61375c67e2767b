import pytest
from closed_form import MS, header
from passafe_dashboard.live.topic_monitor import TopicMonitor
from passafe_protocol.topics import HEALTH, SCENARIO, TICK


def test_rate_is_messages_a_second() -> None:
    monitor = TopicMonitor(TICK, "filter")
    for k in range(3000):
        monitor.receive(header("filter", k), k * MS)
    assert monitor.statistics(2999 * MS).rate_hz == pytest.approx(1000.0)


def test_rate_of_a_silent_topic_goes_to_zero() -> None:
    monitor = TopicMonitor(TICK, "filter")
    for k in range(3000):
        monitor.receive(header("filter", k), k * MS)
    assert monitor.statistics(6999 * MS).rate_hz == pytest.approx(0.25)


def test_missing_repeated_and_foreign_messages_are_counted() -> None:
    monitor = TopicMonitor(TICK, "filter")
    taken = [
        monitor.receive(header("filter", sequence, epoch=epoch), 0)
        for sequence, epoch in ((0, 5), (3, 5), (1, 5), (3, 5), (4, 4))
    ]
    assert taken == [True, True, True, False, False]
    view = monitor.statistics(0)
    assert (view.received, view.gaps, view.refused) == (3, 1, 2)


def test_lateness_depends_on_the_deadline_of_the_topic() -> None:
    monitor = TopicMonitor(HEALTH, "plant")
    monitor.receive(header("plant", 0), 0)
    assert not monitor.statistics(3_050 * MS).late
    assert monitor.statistics(3_150 * MS).late
    assert monitor.statistics(3_150 * MS).age_s == pytest.approx(3.15)


def test_a_topic_without_deadline_is_never_late() -> None:
    monitor = TopicMonitor(SCENARIO, "filter")
    monitor.receive(header("filter", 0), 0)
    assert not monitor.statistics(10**15).late
