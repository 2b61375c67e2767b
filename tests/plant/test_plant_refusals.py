"""Inputs that the plant node refuses and counts."""

import pytest
from passafe_protocol.messages import UNSEQUENCED, PlantInput, Received
from passafe_services.plant.input_check import FAR_NS
from stepped_plant import BOUND, HOLDING, MS, RUNNING, WAITING, U, head, loose, make_node, sequenced, states


@pytest.mark.parametrize(
    "u",
    [
        (float("nan"), 0.0),
        (float("inf"), 0.0),
        (BOUND + 1.0, 0.0),
        (0.0,),
        (0.0, 0.0, 0.0),
        (),
    ],
)
def test_an_input_that_cannot_be_applied_is_refused_and_counted(u: tuple[float, ...]) -> None:
    node = make_node()

    state = states(node, 1, sequenced(0, 1, u))[-1]

    assert (state.phase, state.inputs_refused, state.input_epoch) == (WAITING, 1, 0)


@pytest.mark.parametrize("u", [(3.0, 4.1), (-5.2, 0.0)])
def test_repeated_inputs_beyond_the_norm_are_refused_too(u: tuple[float, ...]) -> None:
    node = make_node(norm=5.0)
    states(node, 1, sequenced(0, 1, (3.0, 4.0)), sequenced(2, 1, (3.0, -4.0), previous_u=(*u, 0.0, 0.0)))

    assert states(node, 1, sequenced(1, 1, u))[-1].inputs_refused == 1
    assert states(node, 2)[-1].phase is HOLDING


@pytest.mark.parametrize("previous_u", [(1.0,), (1.0, 2.0, 3.0)])
def test_repeats_of_the_wrong_shape_are_refused(previous_u: tuple[float, ...]) -> None:
    assert states(make_node(), 1, sequenced(1, 1, previous_u=previous_u))[-1].inputs_refused == 1


@pytest.mark.parametrize(
    ("body", "scheduled_ns"),
    [
        (PlantInput(1, U, FAR_NS + 1, 0, (FAR_NS + 1) % MS), 0),
        (PlantInput(1, U, -1, 0, 0), 0),  # plant time is never negative: −1 stands for none
        (PlantInput(1, U, 0, 0, 0), FAR_NS + 1),
        (PlantInput(1, U, 0, 0, 0), -FAR_NS - 1),
        (PlantInput(1, U, 2 * MS, 0, 0, UNSEQUENCED, (0.0,) * 4), 0),  # repeats inputs of ticks before the first
    ],
)
def test_numbers_that_no_filter_has_are_refused(body: PlantInput, scheduled_ns: int) -> None:
    state = states(make_node(), 1, Received(head(1, scheduled_ns), body, MS))[-1]

    assert (state.phase, state.inputs_refused) == (WAITING, 1)


def test_session_of_an_earlier_term_is_refused() -> None:
    node = make_node()
    states(node, 1, *(sequenced(due_ms, 1, epoch=9, term=3) for due_ms in (0, 1, 3)))
    still = states(node, 2, sequenced(20, 2, first=20, epoch=2, term=4))[-1]

    state = states(node, 3, sequenced(2, 3, epoch=9, term=3))[-1]

    assert (still.phase, still.inputs_refused, still.input_epoch) == (RUNNING, 1, 2)
    assert (state.phase, state.inputs_refused, state.input_epoch) == (HOLDING, 2, 2)


def test_an_unsequenced_input_is_refused() -> None:
    node = make_node()

    resting = states(node, 1, loose(1, 0, 1))[-1]
    states(node, 2, sequenced(0, 2), sequenced(1, 2))
    running = states(node, 3, loose(9, 1, 3, u=(9.0, 9.0)))[-1]

    assert (resting.phase, resting.inputs_refused, resting.input_epoch) == (WAITING, 1, 0)
    assert (running.phase, running.u, running.inputs_refused) == (RUNNING, U, 2)
