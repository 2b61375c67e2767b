"""The latch of the emergency stop by itself: what latches it, what clears it, what it admits."""

from passafe_protocol.messages import (
    EmergencyStop,
    Event,
    Header,
    Message,
    OperatorCommand,
    PlantInput,
    Received,
    StopClear,
)
from passafe_services.plant.stop_latch import SPENT, StopLatch


def receive(latch: StopLatch, body: Message, source: str = "console") -> Event | None:
    return latch.receive(Received(Header(source, 3, 0, 0, 0, 0, 0), body, 0))


def press(latch: StopLatch, number: int, source: str = "console") -> Event | None:
    return receive(latch, EmergencyStop(number, "a person in the way"), source)


def clear(latch: StopLatch, number: int) -> Event | None:
    return receive(latch, StopClear(number, "the way is free"), "dashboard")


def plant_input(stops_cleared: int = 0) -> PlantInput:
    return PlantInput(1, (0.0,), 0, 0, stops_cleared=stops_cleared)


def test_any_press_latches_and_says_who_and_why() -> None:
    latch = StopLatch()
    assert latch.admits(plant_input())

    assert press(latch, 11, "operator") == Event(
        "warning", "emergency stop latched, pressed at operator: a person in the way"
    )
    assert (latch.is_latched, latch.stop, latch.source) == (True, 11, "operator")
    assert not latch.admits(plant_input())
    assert press(latch, 11, "operator") is None


def test_only_its_own_name_clears_it() -> None:
    latch = StopLatch()
    assert clear(latch, 11) is None
    press(latch, 11)

    assert clear(latch, 12) == Event("warning", "refused to clear: got stop 12, allowed 11, the one latched")
    assert clear(latch, 12) is None  # reported once
    assert latch.is_latched
    assert clear(latch, 11) == Event("info", "emergency stop cleared at dashboard: the way is free")
    assert (latch.is_latched, latch.source, latch.cleared) == (False, "", 1)


def test_a_press_that_the_clearing_person_did_not_see_stays() -> None:
    latch = StopLatch()
    press(latch, 11)
    press(latch, 12, "operator")

    clear(latch, 11)

    assert (latch.stop, latch.source) == (12, "operator")


def test_late_repeats_of_cleared_presses_latch_nothing() -> None:
    latch = StopLatch()
    press(latch, 11)
    press(latch, 12)
    clear(latch, 12)

    assert press(latch, 11) is None
    assert press(latch, 12) is None
    assert not latch.is_latched
    press(latch, 13)
    assert latch.is_latched


def test_every_press_shows_to_its_sender_while_it_repeats() -> None:
    latch = StopLatch()
    shown = [(press(latch, number) and latch.stop) or latch.stop for number in (11, 12, 11, 12)]

    assert shown == [11, 12, 11, 12]


def test_inputs_decided_before_the_clear_are_refused_for_good() -> None:
    latch = StopLatch()
    for number in (1, 2, 3):
        press(latch, number)
        clear(latch, number)

        assert [latch.admits(plant_input(known)) for known in range(5)] == [known == number for known in range(5)]


def test_a_latch_may_start_latched() -> None:
    latch = StopLatch(77)

    assert (latch.is_latched, latch.stop, latch.source) == (True, 77, "plant")
    clear(latch, 77)
    assert latch.admits(plant_input(1))
    assert press(latch, 77) is None  # spent


def test_memory_of_presses_is_bounded_to_the_safe_side() -> None:
    latch = StopLatch()
    for number in range(1, 10_000):
        press(latch, number)
    clear(latch, 9_999)

    assert all(press(latch, number) is None for number in range(10_000 - SPENT, 10_000))
    assert press(latch, 1) is not None
    assert latch.is_latched


def test_other_messages_are_none_of_its_business() -> None:
    assert receive(StopLatch(), OperatorCommand((0.0,), (), enabled=True, device="lag")) is None
