import numpy as np
import pytest
from any_inputs import Steps, any_steps
from hypothesis import given, settings
from modelled_robot import modelled_robot
from passafe_protocol.codec import encode
from passafe_protocol.messages import UNSEQUENCED, Event, Header, PlantInput, PlantPhase, PlantState, Received
from passafe_services.plant.playout_buffer import MOST_PENDING
from passafe_services.plant.unpredicted_node import UnpredictedPlantNode
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import SampledPlant, damped_point
from passafe.limits import Limits

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)
U = (1.0, 0.0)
LIMITS = Limits.of(2, 100.0)
ROBOT = damped_point(sigma=1.0, gamma_1=10.0)
PLANT = SampledPlant(ROBOT.system, ROBOT.system.x.T @ ROBOT.system.x, 1e-3)
WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase


def make_node(*, playout_ns: int = 0, hold_ns: int = 3 * MS) -> UnpredictedPlantNode:
    rule = FailSafe(ROBOT, LIMITS, period_ns=MS, hold_ns=hold_ns)
    robot = modelled_robot(PLANT, rule, x0=X0, period_ns=MS, playout_ns=playout_ns)
    return UnpredictedPlantNode(robot, LIMITS)


def head(epoch: int = 1, scheduled_ns: int = 0) -> Header:
    return Header("filter", epoch, 0, scheduled_ns, 0, 0, 0)


def unsequenced(
    tick: int, due_ms: int, at_ms: int, u: tuple[float, ...] = U, epoch: int = 1, term: int = 0
) -> Received:
    return Received(head(epoch), PlantInput(tick, u, due_ms * MS, 10 * MS), at_ms * MS, term)


def states(node: UnpredictedPlantNode, at_ms: int, *inbox: Received) -> list[PlantState]:
    return [body for _, body in node.step(at_ms * MS, inbox) if isinstance(body, PlantState)]


def test_plant_time_begins_one_playout_time_after_first_input() -> None:
    node = make_node(playout_ns=5 * MS)

    assert states(node, 10, unsequenced(1, 0, 10))[0].phase is WAITING
    assert states(node, 14, unsequenced(2, 1, 14))[0].phase is WAITING
    [first] = states(node, 15)
    [second] = states(node, 16)

    assert (first.phase, first.plant_ns, first.u, first.x) == (RUNNING, 0, (1.0, 0.0), X0)
    assert (second.plant_ns, second.applied_tick) == (MS, 2)
    assert first.input_lead_ns == 2 * MS


@pytest.mark.parametrize("u", [(float("nan"), 0.0), (float("inf"), 0.0), (100.5, 0.0), (0.0,), (0.0, 0.0, 0.0), ()])
def test_an_input_that_cannot_be_applied_is_refused(u: tuple[float, ...]) -> None:
    state = states(make_node(), 1, unsequenced(1, 0, 1, u))[-1]

    assert (state.phase, state.inputs_refused, state.input_epoch) == (WAITING, 1, 0)


def test_a_late_input_is_applied_at_once_and_counted() -> None:
    node = make_node()
    states(node, 1, unsequenced(1, 0, 1))
    states(node, 4)

    state = states(node, 5, unsequenced(2, 1, 5, u=(7.0, 0.0)))[-1]

    assert (state.applied_tick, state.u, state.inputs_late, state.input_since_ns) == (2, (7.0, 0.0), 1, MS)
    assert state.input_lead_ns == -3 * MS
    assert state.received_tick == 2


def test_an_older_input_never_replaces_a_newer_one() -> None:
    node = make_node()
    states(node, 1, unsequenced(5, 0, 1, u=(5.0, 0.0)))

    state = states(node, 2, unsequenced(4, 1, 2, u=(4.0, 0.0)))[-1]

    assert (state.u, state.applied_tick) == ((5.0, 0.0), 5)


def test_ticks_of_a_newer_filter_begin_anew() -> None:
    node = make_node()
    states(node, 1, unsequenced(5, 0, 1, epoch=9))

    state = states(node, 2, unsequenced(1, 1, 2, (3.0, 0.0), epoch=2, term=1), unsequenced(9, 1, 2, epoch=9))[-1]

    assert (state.u, state.applied_tick, state.received_tick) == ((3.0, 0.0), 1, 1)
    assert (state.inputs_refused, state.input_epoch) == (1, 2)


def test_an_input_is_held_then_the_fail_safe_takes_over() -> None:
    node = make_node(hold_ns=2 * MS)
    states(node, 1, unsequenced(1, 0, 1))

    assert [states(node, k)[-1].phase for k in (2, 3, 4)] == [HOLDING, FAIL_SAFE, FAIL_SAFE]
    back = node.step(5 * MS, [unsequenced(2, 4, 5)])
    [state] = [body for _, body in back if isinstance(body, PlantState)]
    assert (state.phase, state.sequence_break_ns) == (RUNNING, 4 * MS)
    assert ["released" in body.text for _, body in back if isinstance(body, Event)] == [True]


def test_inputs_due_in_the_far_future_fill_no_buffer() -> None:
    node = make_node()
    states(node, 1, unsequenced(1, 0, 1))
    forged = [unsequenced(2, 10**9 + k, 2) for k in range(MOST_PENDING + 1)]

    refused = states(node, 2, *forged)[-1]
    state = states(node, 3, unsequenced(3, 2, 3, (5.0, 0.0)))[-1]

    assert refused.inputs_refused == MOST_PENDING + 1
    assert (state.u, state.applied_tick, state.inputs_refused) == ((5.0, 0.0), 3, MOST_PENDING + 1)


def test_a_sequenced_input_is_refused() -> None:
    node = make_node()
    states(node, 1, unsequenced(1, 0, 1))
    sequenced = PlantInput(2, (9.0, 9.0), MS, 10 * MS, MS, UNSEQUENCED)

    state = states(node, 2, Received(head(), sequenced, 2 * MS))[-1]

    assert (state.u, state.inputs_refused) == (U, 1)


RULE = FailSafe(ROBOT, LIMITS, period_ns=MS, hold_ns=2 * MS)


@settings(max_examples=60)
@given(any_steps(sequenced=False))
def test_no_messages_make_its_inputs_or_states_unbounded(steps: Steps) -> None:
    node, at_ms = UnpredictedPlantNode(modelled_robot(PLANT, RULE, x0=X0, period_ns=MS), LIMITS), 1
    for skipped, bodies in steps:
        at_ms += 1 + skipped
        inbox = [Received(head(epoch, made_ns), body, at_ms * MS) for epoch, made_ns, body in bodies]
        for state in states(node, at_ms, *inbox):
            assert all(-100.0 <= value <= 100.0 for value in state.u)
            assert len(state.u) == 2
            assert np.isfinite(state.x).all()
            assert encode(head(), state)
