"""The plant node: its time, its motion, its sequences of inputs."""

import numpy as np
import pytest
from passafe_protocol.messages import UNSEQUENCED, Event, PlantState
from stepped_plant import FAIL_SAFE, HOLDING, MS, RUNNING, WAITING, X0, make_node, sequenced, states


def test_it_rests_at_x0_until_an_input_comes() -> None:
    node = make_node()

    found = [states(node, k)[0] for k in range(3)]

    assert {state.phase for state in found} == {WAITING}
    assert {(state.plant_ns, state.x, state.sequence_break_ns) for state in found} == {(0, X0, UNSEQUENCED)}


def test_plant_time_begins_one_playout_time_after_first_input() -> None:
    node = make_node(playout_ns=5 * MS)

    assert states(node, 10, sequenced(0, 10))[0].phase is WAITING
    assert states(node, 14)[0].phase is WAITING
    [first] = states(node, 15)
    [second] = states(node, 16)

    assert (first.phase, first.plant_ns, first.u, first.x) == (RUNNING, 0, (1.0, 0.0), X0)
    assert second.plant_ns == MS
    assert first.input_lead_ns == 5 * MS


def test_plant_time_begins_with_the_newest_sequence() -> None:
    node = make_node(playout_ns=5 * MS)
    states(node, 10, sequenced(0, 10))
    assert states(node, 12, sequenced(3000, 12, (2.0, 0.0), first=3000, epoch=2))[0].plant_ns == 3000 * MS

    assert states(node, 16, sequenced(1, 16))[0].phase is WAITING
    [first] = states(node, 17)

    assert (first.phase, first.plant_ns, first.u, first.inputs_refused) == (RUNNING, 3000 * MS, (2.0, 0.0), 1)


def test_first_input_without_effect_leaves_the_plant_at_rest() -> None:
    node = make_node(playout_ns=2 * MS)
    states(node, 1, sequenced(1, 1, previous_u=(float("nan"), 0.0)))

    found = [states(node, k)[-1] for k in range(2, 9)]
    assert {(state.phase, state.plant_ns, state.x) for state in found} == {(WAITING, 0, X0)}
    states(node, 9, sequenced(7, 9, first=7))
    assert states(node, 11)[-1].phase is RUNNING


def test_the_motion_is_the_closed_form_of_the_damped_point() -> None:
    node = make_node()
    states(node, 1, *(sequenced(k, 1, u=(3.0, -1.0)) for k in range(101)))

    state = states(node, 101)[-1]

    t, x1, x2, u = 0.1, np.array([2.0, 2.0]), np.array([-1.0, -1.0]), np.array([3.0, -1.0])
    velocity = u + (x2 - u) * np.exp(-t)
    position = x1 + u * t + (x2 - u) * (1 - np.exp(-t))
    assert state.phase is RUNNING
    assert state.x == pytest.approx([*position, *velocity], abs=1e-12)
    assert state.energy_in_j == pytest.approx(float(u @ (position - x1)), abs=1e-12)
    assert state.energy_stored_j == pytest.approx(float(position @ position + velocity @ velocity), abs=1e-12)


def test_skipped_steps_give_one_state_per_period() -> None:
    node = make_node()
    states(node, 1, *(sequenced(k, 1) for k in range(10)))

    found = states(node, 6)

    assert [state.plant_ns // MS for state in found] == [1, 2, 3, 4, 5]
    assert [state.applied_tick for state in found] == [2, 3, 4, 5, 6]
    assert [state.input_since_ns // MS for state in found] == [1, 2, 3, 4, 5]


def test_missing_input_leads_to_hold_fail_safe_and_new_sequence() -> None:
    node = make_node(hold_ns=3 * MS)
    states(node, 1, sequenced(0, 1), sequenced(1, 1), sequenced(3, 1))

    found = [states(node, 1 + k)[-1] for k in range(1, 4)]
    sent = node.step(5 * MS, ())
    [failed] = [body for _, body in sent if isinstance(body, PlantState)]
    [event] = [body for _, body in sent if isinstance(body, Event)]
    states(node, 6, sequenced(6, 6), sequenced(6, 6, first=6, basis=1), sequenced(6, 6, (0.5, 0.5), first=6, basis=2))
    back = node.step(7 * MS, ())

    assert [state.phase for state in found] == [RUNNING, HOLDING, HOLDING]
    assert [state.sequence_break_ns for state in found] == [UNSEQUENCED, 2 * MS, 2 * MS]
    assert {state.input_since_ns for state in found} == {MS}
    assert (failed.phase, failed.sequence_break_ns) == (FAIL_SAFE, 2 * MS)
    assert failed.u == pytest.approx([-9.0 * value for value in failed.x[2:]])
    assert "fail-safe" in event.text
    [state] = [body for _, body in back if isinstance(body, PlantState)]
    assert (state.phase, state.u, state.inputs_refused) == (RUNNING, (0.5, 0.5), 2)
    assert ["released" in body.text for _, body in back if isinstance(body, Event)] == [True]


@pytest.mark.parametrize(("hold_ns", "held"), [(0, 0), (MS, 0), (2 * MS, 1), (2 * MS + 1, 1), (5 * MS, 4), (9 * MS, 4)])
def test_an_input_may_ask_for_a_shorter_hold_than_the_plants(hold_ns: int, held: int) -> None:
    node = make_node(hold_ns=5 * MS)
    states(node, 1, sequenced(0, 1, hold_ns=hold_ns))
    phases = [states(node, 1 + k)[-1].phase for k in range(1, 8)]

    assert phases == [HOLDING] * held + [FAIL_SAFE] * (7 - held)


def test_broken_sequence_stays_broken_whatever_arrives_later() -> None:
    node = make_node(hold_ns=2 * MS)
    states(node, 1, sequenced(0, 1))
    states(node, 2)

    found = [states(node, at_ms, sequenced(at_ms - 2, at_ms), sequenced(at_ms + 3, at_ms))[-1] for at_ms in range(3, 9)]

    assert {state.sequence_break_ns for state in found} == {MS}
    assert {state.phase for state in found} == {FAIL_SAFE}
    assert [state.inputs_refused for state in found] == [2, 4, 6, 8, 10, 12]
    assert [state.inputs_late for state in found] == [1, 2, 3, 4, 5, 6]


def test_lost_message_repeated_in_time_breaks_nothing() -> None:
    node = make_node()
    states(node, 1, sequenced(0, 1), sequenced(3, 1, (4.0, 4.0), previous_u=(3.0, 3.0, 2.0, 2.0)))

    found = [states(node, k)[-1] for k in range(2, 6)]

    assert [(state.phase, state.u) for state in found] == [
        (RUNNING, (2.0, 2.0)),
        (RUNNING, (3.0, 3.0)),
        (RUNNING, (4.0, 4.0)),
        (HOLDING, (4.0, 4.0)),
    ]
    assert [state.applied_tick for state in found] == [2, 3, 4, 4]
