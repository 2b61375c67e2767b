from itertools import pairwise

import pytest
from msgspec.structs import replace
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.filter.playout_schedule import SLEW_STEPS, PlayoutSchedule

MS = 1_000_000
WAITING, RUNNING = PlantPhase.WAITING, PlantPhase.RUNNING
EPOCH = 7


def state(plant_ms: int, *, phase: PlantPhase = RUNNING, transit_ms: float = -100, epoch: int = EPOCH) -> PlantState:
    """State whose transit time says that inputs made at time t of the filter's clock came at plant time t + transit."""
    body = PlantState(plant_ms * MS, (0.0,), (0.0,), (0.0,), 0, phase, 0.0, 0.0, 0, 0, 0, 0.0, 0)
    return replace(body, input_transit_ns=round(transit_ms * MS), input_epoch=epoch)


def make_schedule(playout_ms: int = 5) -> PlayoutSchedule:
    return PlayoutSchedule(period_ns=MS, playout_ns=playout_ms * MS, epoch=EPOCH)


def started(playout_ms: int = 5) -> PlayoutSchedule:
    """Return a schedule whose step at 100 ms has the effective plant time 0."""
    schedule = make_schedule(playout_ms)
    schedule.effective_ns(100 * MS, state(0, phase=WAITING))
    return schedule


def test_waiting_plant_gets_inputs_from_its_own_time_on() -> None:
    schedule = make_schedule()
    waiting = state(0, phase=WAITING, epoch=0)

    assert [schedule.effective_ns((100 + k) * MS, waiting) for k in range(4)] == [0, MS, 2 * MS, 3 * MS]


def test_skipped_step_does_not_shift_the_following_ones() -> None:
    assert started().effective_ns(103 * MS, state(0, phase=WAITING)) == 3 * MS


def test_a_filter_that_joins_a_running_plant_starts_ahead_of_it() -> None:
    assert make_schedule().effective_ns(0, state(700, epoch=0)) == 706 * MS


def test_effective_time_covers_transit_and_playout_at_once() -> None:
    schedule = started()
    slower = state(8, transit_ms=-98)  # two periods later than at the play-out time: −100 − 5 was in step

    moved = schedule.effective_ns(110 * MS, slower)
    again = schedule.effective_ns(111 * MS, slower)

    assert moved == (110 - 98 + 5) * MS
    assert again == moved + MS
    assert schedule.moved == 1


def test_transit_is_rounded_up_to_whole_periods() -> None:
    schedule = started()

    assert schedule.effective_ns(110 * MS, state(8, transit_ms=-97.9999)) == (110 - 97 + 5) * MS
    assert schedule.effective_ns(111 * MS, state(9, transit_ms=-97.0001)) == (111 - 97 + 5) * MS
    assert schedule.moved == 1


def test_schedule_moves_back_slowly_and_keeps_two_periods() -> None:
    schedule = started()
    schedule.effective_ns(110 * MS, state(8, transit_ms=-85))
    offsets = [
        schedule.effective_ns((111 + k) * MS, state(9, transit_ms=-90)) - (111 + k) * MS for k in range(8 * SLEW_STEPS)
    ]
    steps = [k for k in range(1, len(offsets)) if offsets[k] != offsets[k - 1]]

    assert {offsets[k] - offsets[k - 1] for k in steps} == {-MS}
    assert [after - before for before, after in pairwise(steps)] == [SLEW_STEPS] * (len(steps) - 1)
    assert offsets[-1] == (-90 + 5 + 1) * MS  # a period in hand, so that it does not oscillate
    assert schedule.moved == 1


@pytest.mark.parametrize("epoch", [0, EPOCH - 1, EPOCH + 1])
def test_transit_times_of_another_session_are_ignored(epoch: int) -> None:
    schedule = started()

    assert schedule.effective_ns(110 * MS, state(3, transit_ms=900, epoch=epoch)) == 10 * MS
    assert [schedule.effective_ns((111 + k) * MS, state(3, transit_ms=-900, epoch=epoch)) for k in range(40)] == [
        (11 + k) * MS for k in range(40)
    ]


def test_a_waiting_plant_does_not_move_it() -> None:
    assert started().effective_ns(110 * MS, state(0, phase=WAITING, transit_ms=900)) == 10 * MS


@pytest.mark.parametrize("epoch", [0, EPOCH])
@pytest.mark.parametrize("playout_ms", [0, 5])
def test_it_never_works_for_a_time_that_the_plant_has_passed(playout_ms: int, epoch: int) -> None:
    schedule = started(playout_ms)

    assert schedule.effective_ns(101 * MS, state(50, epoch=epoch, transit_ms=-150)) == 51 * MS
    assert schedule.effective_ns(102 * MS, state(51, epoch=epoch, transit_ms=-150)) == 52 * MS


def test_after_a_restart_it_begins_with_the_other_plant() -> None:
    schedule = started()
    schedule.effective_ns(110 * MS, state(8, transit_ms=300))

    schedule.restart()

    assert schedule.effective_ns(200 * MS, state(0, phase=WAITING)) == 0
