import numpy as np
import pytest

from passafe import SampledPlant, damped_point
from passafe.limits import Limits
from protocol.messages import Event, Header, PlantInput, PlantPhase, PlantState, Received
from services.plant.node import PlantNode

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)
HEADER = Header("filter", 1, 0, 0, 0, 0, 0)


def make_node(*, playout_ns: int = 0, hold_ns: int = 3 * MS) -> PlantNode:
    robot = damped_point(sigma=1.0, gamma_1=10.0)
    V = robot.system.x.T @ robot.system.x
    return PlantNode(
        robot,
        SampledPlant(robot.system, V, 1e-3),
        x0=X0,
        period_ns=MS,
        playout_ns=playout_ns,
        hold_ns=hold_ns,
        limits=Limits(magnitude=(100.0, 100.0)),
    )


def received(tick: int, due_ms: int, at_ms: int, u: tuple[float, ...] = (1.0, 0.0), hold_ns: int = 10 * MS) -> Received:
    return Received(HEADER, PlantInput(tick, u, due_ms * MS, hold_ns), at_ms * MS)


def states(node: PlantNode, at_ms: int, *inbox: Received) -> list[PlantState]:
    return [body for _, body in node.step(at_ms * MS, inbox) if isinstance(body, PlantState)]


def test_it_rests_at_x0_until_an_input_comes() -> None:
    node = make_node()

    found = [states(node, k)[0] for k in range(3)]

    assert {state.phase for state in found} == {PlantPhase.WAITING}
    assert {(state.plant_ns, state.x) for state in found} == {(0, X0)}


def test_plant_time_begins_one_playout_after_the_first_input_arrived() -> None:
    node = make_node(playout_ns=5 * MS)

    assert states(node, 10, received(1, 0, 10))[0].phase is PlantPhase.WAITING
    assert states(node, 14)[0].phase is PlantPhase.WAITING
    [first] = states(node, 15)
    [second] = states(node, 16)

    assert (first.phase, first.plant_ns, first.u, first.x) == (PlantPhase.RUNNING, 0, (1.0, 0.0), X0)
    assert second.plant_ns == MS
    assert first.input_slack_ns == 5 * MS


def test_the_motion_is_the_closed_form_of_the_damped_point() -> None:
    node = make_node()
    states(node, 1, *(received(k + 1, k, 1, u=(3.0, -1.0)) for k in range(100)))

    [state] = [states(node, 1 + k)[-1] for k in range(1, 101)][-1:]

    t, x1, x2, u = 0.1, np.array([2.0, 2.0]), np.array([-1.0, -1.0]), np.array([3.0, -1.0])
    velocity = u + (x2 - u) * np.exp(-t)
    position = x1 + u * t + (x2 - u) * (1 - np.exp(-t))
    assert state.x == pytest.approx([*position, *velocity], abs=1e-12)
    assert state.energy_in_j == pytest.approx(float(u @ (position - x1)), abs=1e-12)
    assert state.energy_stored_j == pytest.approx(float(position @ position + velocity @ velocity), abs=1e-12)


def test_a_driver_that_skipped_steps_gets_one_state_for_every_period() -> None:
    node = make_node()
    states(node, 1, *(received(k + 1, k, 1) for k in range(10)))

    found = states(node, 6)

    assert [state.plant_ns // MS for state in found] == [1, 2, 3, 4, 5]
    assert [state.applied_tick for state in found] == [2, 3, 4, 5, 6]


def test_a_missing_input_is_held_then_the_fail_safe_takes_over_and_gives_back() -> None:
    node = make_node(hold_ns=3 * MS)
    states(node, 1, received(1, 0, 1))

    held = [states(node, 1 + k)[-1] for k in range(1, 4)]
    sent = node.step(5 * MS, ())
    [failed] = [body for _, body in sent if isinstance(body, PlantState)]
    [event] = [body for _, body in sent if isinstance(body, Event)]
    back = states(node, 6, received(7, 5, 6, u=(0.5, 0.5)))[-1]

    assert [state.phase for state in held] == [PlantPhase.HOLDING] * 3
    assert failed.phase is PlantPhase.FAIL_SAFE
    assert failed.u == pytest.approx([-9.0 * value for value in failed.x[2:]])
    assert "fail-safe" in event.text
    assert (back.phase, back.u) == (PlantPhase.RUNNING, (0.5, 0.5))


def test_an_input_may_ask_for_a_shorter_hold_than_the_plants() -> None:
    node = make_node(hold_ns=100 * MS)
    states(node, 1, received(1, 0, 1, hold_ns=MS))

    assert states(node, 2)[-1].phase is PlantPhase.HOLDING
    assert states(node, 3)[-1].phase is PlantPhase.FAIL_SAFE


def test_a_late_input_is_applied_at_once_and_counted() -> None:
    node = make_node()
    states(node, 1, received(1, 0, 1))
    states(node, 4)

    state = states(node, 5, received(2, 1, 5, u=(7.0, 0.0)))[-1]

    assert (state.applied_tick, state.u, state.inputs_late) == (2, (7.0, 0.0), 1)
    assert state.input_slack_ns == -3 * MS
    assert state.received_tick == 2


@pytest.mark.parametrize("u", [(float("nan"), 0.0), (float("inf"), 0.0), (101.0, 0.0), (0.0,), (0.0, 0.0, 0.0), ()])
def test_an_input_that_cannot_be_applied_is_refused_and_counted(u: tuple[float, ...]) -> None:
    node = make_node()

    state = states(node, 1, received(1, 0, 1, u=u))[-1]

    assert (state.phase, state.inputs_refused) == (PlantPhase.WAITING, 1)


def test_an_older_input_never_replaces_a_newer_one() -> None:
    node = make_node()
    states(node, 1, received(5, 0, 1, u=(5.0, 0.0)))

    state = states(node, 2, received(4, 1, 2, u=(4.0, 0.0)))[-1]

    assert (state.u, state.applied_tick) == ((5.0, 0.0), 5)
