"""Any messages to the plant node, and sequences of two filters in any order."""

import numpy as np
from any_inputs import Steps, any_steps
from hypothesis import given, settings
from hypothesis import strategies as st
from modelled_robot import modelled_robot
from passafe_protocol.codec import encode
from passafe_protocol.messages import UNSEQUENCED, PlantState, Received
from passafe_services.plant.node import PlantNode
from passafe_services.plant_contract.fail_safe import FailSafe
from stepped_plant import BOUND, MS, RUNNING, WAITING, X0, head, sequenced, states

from passafe import SampledPlant, damped_point
from passafe.limits import Limits


@settings(max_examples=60)
@given(any_steps(sequenced=True))
def test_any_messages_keep_inputs_bounded_and_states_valid(steps: Steps) -> None:
    node, at_ms = fuzzed(), 1
    for skipped, bodies in steps:
        at_ms += 1 + skipped
        inbox = [Received(head(epoch, made_ns), body, at_ms * MS) for epoch, made_ns, body in bodies]
        for state in states(node, at_ms, *inbox):
            assert all(-BOUND <= value <= BOUND for value in state.u)
            assert len(state.u) == 2
            assert np.isfinite(state.x).all()
            assert encode(head(), state)
        assert len(node._inputs._pending) <= 7 * len(steps) * 4


@settings(max_examples=40)
@given(st.data())
def test_running_sequence_applies_its_inputs_in_order(data: st.DataObject) -> None:
    """Sequences of two filters, lost, late, overtaken and repeated: u encodes sequence and period of an input."""
    node, sequences, broken_ns = fuzzed(), [(0, None)], UNSEQUENCED
    before: PlantState | None = None
    for at_ms in range(1, 40):
        inbox = []
        for _ in range(data.draw(st.integers(0, 3))):
            which = data.draw(st.integers(0, len(sequences) - 1))
            first, basis = sequences[which]
            due = first + data.draw(st.integers(0, 12))
            count = data.draw(st.integers(0, min(due - first, 4)))
            previous_u = sum(((float(which), float(due - i)) for i in range(1, count + 1)), ())
            u = (float(which), float(due))
            inbox.append(sequenced(due, at_ms, u, first=first, basis=basis, previous_u=previous_u, epoch=1 + which % 2))
        for state in states(node, at_ms, *inbox):
            if state.phase is RUNNING:
                which = int(state.u[0])
                assert state.u[1] * MS == state.plant_ns
                if before is None or before.phase is not RUNNING:
                    assert sequences[which][0] * MS == state.plant_ns
                elif state.plant_ns > before.plant_ns:
                    assert state.u == (before.u[0], before.u[1] + 1.0)
                if sequences[which][1] is not None:
                    assert sequences[which][1] * MS == state.sequence_break_ns
            if state.sequence_break_ns != broken_ns:
                broken_ns = state.sequence_break_ns
                now = state.plant_ns // MS
                sequences += [(now + ahead, broken_ns // MS) for ahead in (2, 3)]
            before = state if state.phase is not WAITING else None


def fuzzed() -> PlantNode:
    """Return a fresh node of a robot that is compiled once."""
    return PlantNode(modelled_robot(PLANT, RULE, x0=X0, period_ns=MS), Limits.of(2, BOUND))


ROBOT = damped_point(sigma=1.0, gamma_1=10.0)
PLANT = SampledPlant(ROBOT.system, ROBOT.system.x.T @ ROBOT.system.x, 1e-3)
RULE = FailSafe(ROBOT, Limits.of(2, BOUND), period_ns=MS, hold_ns=2 * MS)
