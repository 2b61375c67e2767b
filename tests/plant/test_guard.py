"""The guard: passes to the bit what keeps the rows, changes the rest, and needs no filter."""

import pytest
from passafe_protocol.messages import Event, GuardAction, PlantPhase, PlantState
from passafe_protocol.topics import EVENT, STATE
from passafe_services.plant.guard import FALLBACK, Guard
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of

SECOND = 1_000_000_000
FAR = (2.0, 2.0, 0.0, 0.0)
NEAR = (1.05, 0.0, 0.0, 0.0)
STILL = (0.0, 0.0)


def guard_of(**overrides: object) -> Guard:
    scenario = load_scenario("notomista-cai-2020", {"rate_hz": 500.0, **overrides})
    return Guard(PlantModel.of(scenario).guard_core)


@pytest.fixture(scope="module")
def guard() -> Guard:
    return guard_of()


def test_an_input_that_keeps_the_rows_passes_to_the_bit(guard: Guard) -> None:
    asked = (0.1 + 0.2, -1e-17)

    judged = guard.judge(FAR, STILL, asked, 0)

    assert judged.u is asked
    assert (judged.action, judged.cause) == (GuardAction.PASSED, "")


def test_an_input_at_the_disk_is_changed_along_it_only(guard: Guard) -> None:
    before = guard.changed

    judged = guard.judge(NEAR, STILL, (-30.0, 3.0), 0)

    assert (judged.action, judged.cause) == (GuardAction.CHANGED, "disk")
    assert judged.u[0] > -30.0
    assert judged.u[1] == pytest.approx(3.0, abs=1e-5)
    assert guard.changed == before + 1


def test_a_state_that_nothing_can_save_ends_in_the_fallback() -> None:
    judged = guard_of(**{"filter.input_bound": 1.0}).judge((1.05, 0.0, -5.0, 0.0), STILL, STILL, 0)

    assert (judged.action, judged.cause) == (GuardAction.FAIL_SAFE, FALLBACK)


def test_limits_of_the_rate_hold_from_the_input_in_force() -> None:
    guard = guard_of(**{"filter.input_rate_bound_per_s": 50.0})

    assert guard.judge(FAR, STILL, (0.1, 0.0), 0).action is GuardAction.PASSED
    assert guard.judge(FAR, STILL, (1.0, 0.0), 0).u == pytest.approx((0.1, 0.0))


def test_events_tell_new_causes_once_a_second(guard: Guard) -> None:
    changed = guard.judge(NEAR, STILL, (-30.0, 0.0), 0)

    assert isinstance(guard.event(changed, 5 * SECOND), Event)
    assert guard.event(changed, 5 * SECOND + 1) is None
    assert guard.event(changed, 7 * SECOND) is None  # the same cause
    fallback = type(changed)(changed.u, GuardAction.FAIL_SAFE, FALLBACK)
    event = guard.event(fallback, 9 * SECOND)
    assert event is not None
    assert event.severity == "error"
    assert guard.event(type(changed)(STILL, GuardAction.PASSED, ""), 11 * SECOND) is None


@pytest.mark.parametrize("mode", ["both", "off"])
def test_a_loop_with_a_guard_keeps_its_disk(mode: str) -> None:
    found: list[PlantState] = []
    overrides = {"rate_hz": 250.0, "duration_s": 1.6, "plant.guard": {}, "filter.mode": mode}
    scenario = load_scenario("notomista-cai-2020", overrides)
    lockstep_loop(scenario, taps={STATE: found.append, EVENT: lambda _: None}).run(steps_of(scenario))
    moving = [state for state in found if state.phase is not PlantPhase.WAITING]

    assert min(state.x[0] ** 2 + state.x[1] ** 2 for state in moving) >= 1.0
    changed = [state for state in moving if state.guard != GuardAction.PASSED]
    assert moving[-1].guarded == len(changed)
    assert all(state.u_asked and state.guard_cause == "disk" for state in changed)
    assert bool(changed) is (mode == "off")  # what the filter certified passes
