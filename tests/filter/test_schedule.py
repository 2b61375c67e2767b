from protocol.messages import PlantPhase, PlantState
from services.filter.schedule import EffectSchedule

MS = 1_000_000


def state(plant_ms: int, *, phase: PlantPhase = PlantPhase.RUNNING, slack_ms: int = 3, tick: int = 0) -> PlantState:
    return PlantState(plant_ms * MS, (0.0,), (0.0,), (0.0,), tick, phase, 0.0, 0.0, slack_ms * MS, 0, 0, 0.0, tick)


def make_schedule() -> EffectSchedule:
    return EffectSchedule(period_ns=MS, playout_ns=5 * MS)


def test_the_first_input_for_a_waiting_plant_is_for_its_own_time_and_the_next_follow_period_by_period() -> None:
    schedule = make_schedule()
    waiting = state(0, phase=PlantPhase.WAITING, slack_ms=0)

    assert [schedule.effective_ns((100 + k) * MS, waiting, k + 1) for k in range(4)] == [0, MS, 2 * MS, 3 * MS]


def test_a_step_that_was_left_out_leaves_out_its_plant_time() -> None:
    schedule = make_schedule()
    schedule.effective_ns(100 * MS, state(0, phase=PlantPhase.WAITING), 1)

    assert schedule.effective_ns(103 * MS, state(0, phase=PlantPhase.WAITING), 2) == 3 * MS


def test_a_filter_that_joins_a_running_plant_starts_ahead_of_it() -> None:
    assert make_schedule().effective_ns(0, state(700), 1) == 706 * MS


def test_a_late_input_moves_the_schedule_once_until_the_plant_tells_of_newer_inputs() -> None:
    schedule = make_schedule()
    schedule.effective_ns(100 * MS, state(0, phase=PlantPhase.WAITING), 1)
    late = state(8, slack_ms=-2, tick=9)

    moved = schedule.effective_ns(110 * MS, late, 11)
    again = schedule.effective_ns(111 * MS, late, 12)

    assert moved == (10 + 7) * MS  # up to the play-out time again: 5 ms and the 2 ms that were missing
    assert again == moved + MS
    assert schedule.moved == 1


def test_it_never_works_for_a_time_that_the_plant_has_passed() -> None:
    schedule = make_schedule()
    schedule.effective_ns(100 * MS, state(0, phase=PlantPhase.WAITING), 1)

    assert schedule.effective_ns(101 * MS, state(50), 2) > 50 * MS
