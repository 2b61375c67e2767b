"""Send times of messages on the receiver's clock."""

import pytest
from passafe_protocol.messages import VIRTUAL_CLOCK, Event, Header, Received
from passafe_services.filter.send_time import SendTime

MS = 1_000_000
OTHER_CLOCK = 99


def message(
    number: int, scheduled_ms: float, received_ms: float, *, epoch: int = 1, clock_id: int = VIRTUAL_CLOCK
) -> Received:
    header = Header("operator", epoch, number, round(scheduled_ms * MS), 0, 0, 0, clock_id)
    return Received(header, Event("info", "any"), round(received_ms * MS))


def test_on_one_clock_the_send_time_is_the_senders() -> None:
    times = SendTime(VIRTUAL_CLOCK)

    assert times.of(message(0, 100, 3100)) == 100 * MS
    assert times.of(message(1, 110, 115)) == 110 * MS


@pytest.mark.parametrize("own", [VIRTUAL_CLOCK, 0])
@pytest.mark.parametrize("ahead_ms", [-86_400_000, 0, 86_400_000])
def test_on_another_clock_the_fastest_message_has_age_zero(own: int, ahead_ms: int) -> None:
    times = SendTime(own)
    ages_ms = []
    for number, delay_ms in enumerate((8, 5, 305, 45)):
        at_ms = 10 * number
        sent = times.of(message(number, at_ms + ahead_ms, at_ms + delay_ms, clock_id=OTHER_CLOCK if own else 0))
        ages_ms.append(at_ms + delay_ms - sent / MS)

    assert ages_ms == pytest.approx([0, 0, 300, 40], abs=0.1)


def test_clock_from_the_future_is_not_the_one_that_it_names() -> None:
    times = SendTime(VIRTUAL_CLOCK)

    assert times.of(message(0, 5000, 10)) == 10 * MS
    assert times.of(message(1, 5010, 20)) == 20 * MS
    assert times.of(message(2, 5020, 5330)) == pytest.approx(30 * MS, abs=MS)  # looks 310 ms old, is 5300


def test_new_session_is_believed_again() -> None:
    times = SendTime(VIRTUAL_CLOCK)
    times.of(message(0, 5000, 10))

    assert times.of(message(0, 20, 60, epoch=2)) == 20 * MS


@pytest.mark.parametrize("scheduled_ms", [10, 0])
def test_clock_that_stands_or_goes_back_begins_anew(scheduled_ms: float) -> None:
    times = SendTime(0)
    times.of(message(0, 10, 15))

    assert times.of(message(1, scheduled_ms, 300)) == 300 * MS


def test_messages_of_one_step_keep_the_estimate() -> None:
    times = SendTime(0)
    times.of(message(0, 10, 15))

    assert times.of(message(1, 20, 125)) == pytest.approx(25 * MS, abs=MS)
    assert times.of(message(2, 20, 125)) == pytest.approx(25 * MS, abs=MS)
