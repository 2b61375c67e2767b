"""Age of commands of an operator on another host, from the echo of a plant state."""

import pytest
from passafe_protocol.messages import VIRTUAL_CLOCK, Header, OperatorCommand, PlantPhase, PlantState, Received
from passafe_services.filter.command_send_time import CommandSendTime
from passafe_services.filter.plant_clock import PlantClock

MS = 1_000_000
FILTER_EPOCH, PLANT_EPOCH = 20, 5
OPERATOR_AHEAD_MS, PLANT_AHEAD_MS = 5_000_000, -900_000


def state(
    sent_ms: float,
    *,
    transit_ms: float = 40,
    clock_id: int = 0,
    ahead_ms: float = PLANT_AHEAD_MS,
    epoch: int = PLANT_EPOCH,
    phase: PlantPhase = PlantPhase.RUNNING,
    input_epoch: int = FILTER_EPOCH,
) -> Received:
    """Return a state of a plant whose plant time is 1000 ms behind the filter's clock."""
    plant_ns = round((sent_ms - 1000) * MS)
    transit_ns = round((transit_ms - 1000) * MS)
    body = PlantState(
        plant_ns, (0.0,), (0.0,), (0.0,), 0, phase, 0.0, 0.0, 0, 0, 0, 0.0, 0, -1, 0, transit_ns, input_epoch
    )
    return Received(Header("plant", epoch, 0, round((sent_ms + ahead_ms) * MS), 0, 0, 0, clock_id), body, 0)


def observed(plant: PlantClock, received: Received) -> None:
    assert isinstance(received.body, PlantState)
    plant.observe(received, received.body)


def command(
    number: int,
    sent_ms: float,
    arrives_ms: float,
    echoed_ms: float | None,
    *,
    for_ms: float = 0.0,
    epoch: int = PLANT_EPOCH,
) -> Received:
    """Return a command that echoes the state that was sent at ``echoed_ms``."""
    echo = () if echoed_ms is None else (epoch, round((echoed_ms + PLANT_AHEAD_MS) * MS), round(for_ms * MS))
    header = Header("operator", 1, number, round((sent_ms + OPERATOR_AHEAD_MS) * MS), 0, 0, 0, 99)
    return Received(header, OperatorCommand((1.0,), (), True, "test", *echo), round(arrives_ms * MS))


def test_delay_that_all_commands_have_is_seen_by_the_echo() -> None:
    """States reach the operator after 30 ms, commands the filter after 500 ms, inputs the plant after 40 ms."""
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    times = CommandSendTime(VIRTUAL_CLOCK, plant)
    observed(plant, state(2000))
    for number, sent_ms in enumerate(range(2000, 2200, 20)):
        age_ms = sent_ms + 500 - times.of(command(number, sent_ms, sent_ms + 500, sent_ms - 42, for_ms=12)) / MS
        assert age_ms == pytest.approx(500 + 30 + 40)


def test_plant_on_the_filters_clock_needs_no_transit_time() -> None:
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    observed(plant, state(2000, clock_id=VIRTUAL_CLOCK, ahead_ms=0, phase=PlantPhase.WAITING))

    assert plant.sent_after_ns(PLANT_EPOCH, 1958 * MS) == 1958 * MS
    assert plant.sent_after_ns(PLANT_EPOCH + 1, 1958 * MS) is None


@pytest.mark.parametrize("bad", [{"phase": PlantPhase.WAITING}, {"input_epoch": FILTER_EPOCH - 1}])
def test_without_an_own_input_the_plants_clock_is_unknown(bad: dict[str, object]) -> None:
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    observed(plant, state(2000, **bad))
    times = CommandSendTime(VIRTUAL_CLOCK, plant)

    assert plant.sent_after_ns(PLANT_EPOCH, 0) is None
    assert times.of(command(0, 1500, 2000, 1400)) == 2000 * MS  # the fastest so far


def test_command_without_an_echo_is_estimated() -> None:
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    observed(plant, state(2000))
    times = CommandSendTime(VIRTUAL_CLOCK, plant)

    assert times.of(command(0, 1500, 2000, None)) == 2000 * MS
    assert times.of(command(1, 1510, 2310, None)) == pytest.approx(2010 * MS, abs=MS)


def test_echo_of_an_ended_plant_keeps_the_last_age() -> None:
    """The plant starts again; for 500 ms commands come that echo the one before."""
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    observed(plant, state(2000))
    times = CommandSendTime(VIRTUAL_CLOCK, plant)
    times.of(command(0, 2000, 2500, 1970))
    observed(plant, state(2510, epoch=PLANT_EPOCH + 1))

    assert times.of(command(1, 2020, 2520, 1990)) == (2520 - 570) * MS
    assert times.of(command(2, 2520, 2530, 2515, epoch=PLANT_EPOCH + 1)) == (2515 - 40) * MS


def test_operators_clock_may_step_when_it_echoes() -> None:
    """A host that was suspended: its clock is 60 s behind from then on, its commands are as fast as before."""
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    observed(plant, state(2000))
    times = CommandSendTime(VIRTUAL_CLOCK, plant)
    times.of(command(0, 2000, 2010, 1990))

    assert 2030 * MS - times.of(command(1, 2020 - 60_000, 2030, 2010)) == 60 * MS


def test_echo_from_the_future_makes_no_command_younger_than_new() -> None:
    plant = PlantClock(VIRTUAL_CLOCK, FILTER_EPOCH)
    observed(plant, state(2000))
    times = CommandSendTime(VIRTUAL_CLOCK, plant)

    assert times.of(command(0, 2000, 2010, 9000)) == 2010 * MS
