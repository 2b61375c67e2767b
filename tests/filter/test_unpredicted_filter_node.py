import pytest
from passafe_protocol.messages import UNSEQUENCED, FilterTick, Header, PlantInput, PlantPhase, PlantState, Received
from passafe_services.filter.build import filter_node
from passafe_services.filter.unpredicted_node import UnpredictedFilterNode
from passafe_services.filter.unpredicted_state import UnpredictedState
from passafe_services.scenarios.load import load_scenario

from passafe import Tank

MS = 1_000_000
SCENARIO = load_scenario("notomista-cai-2020", {"filter.prediction": False})


def plant_state(plant_ms: int, phase: PlantPhase = PlantPhase.RUNNING, **energies: float) -> PlantState:
    x = (2.0 + plant_ms, 2.0, -1.0, -1.0)
    energy_in_j, stored_j = energies.get("energy_in_j", 0.0), energies.get("stored_j", 10.0)
    return PlantState(plant_ms * MS, x, x[2:], (0.0, 0.0), 0, phase, energy_in_j, stored_j, 0, 0, 0, 0.0, 0)


def sent(
    node: UnpredictedFilterNode, at_ms: int, *states: tuple[int, PlantState]
) -> tuple[list[PlantInput], list[FilterTick]]:
    inbox = [Received(Header("plant", 1, number, 0, 0, 0, 0), state, at_ms * MS) for number, state in states]
    made = [body() if callable(body) else body for _, body in node.step(at_ms * MS, inbox)]
    return [body for body in made if isinstance(body, PlantInput)], [b for b in made if isinstance(b, FilterTick)]


def test_it_decides_for_the_newest_state_and_sends_unsequenced() -> None:
    node = filter_node(SCENARIO, "lockstep", 1)
    assert isinstance(node, UnpredictedFilterNode)

    [first], [reported] = sent(node, 1, (1, plant_state(0, PlantPhase.WAITING)))
    [second], [later] = sent(node, 2, (2, plant_state(0, PlantPhase.WAITING)), (3, plant_state(1)))

    assert (first.tick, first.u, first.effective_plant_ns) == (1, reported.u, 0)
    assert (first.input_sequence_start_ns, first.known_break_ns, first.previous_u) == (UNSEQUENCED, UNSEQUENCED, ())
    assert (second.effective_plant_ns > first.effective_plant_ns, later.horizon_ns) == (True, 0)
    assert (reported.x_hat[0], later.x_hat[0]) == (2.0, 3.0)


def test_no_input_is_for_a_plant_time_that_was_decided() -> None:
    node = filter_node(SCENARIO, "lockstep", 1)
    assert isinstance(node, UnpredictedFilterNode)
    state = plant_state(0, PlantPhase.WAITING)
    node.confirm(state)
    assert node.next_input(state, 4 * MS) == (4 * MS, False)
    node.message(5, (4.0, -1.0), 4 * MS, 0)

    assert node.next_input(state, 4 * MS) == (5 * MS, False)
    assert node.next_input(state, 7 * MS) == (7 * MS, False)
    node.restart()
    assert node.next_input(state, 2 * MS) == (2 * MS, False)


def test_state_is_the_newest_whatever_the_time() -> None:
    unpredicted = UnpredictedState(Tank(initial_j=7.0, reserve_j=5.0, max_j=1000.0))
    old, new = plant_state(0), plant_state(2, energy_in_j=3.0, stored_j=11.0)
    unpredicted.confirm(old)
    at_first = unpredicted.at(50 * MS)
    unpredicted.record_sent((4.0, 2.0))
    unpredicted.confirm(new)
    unpredicted.confirm(old)

    found = unpredicted.at(51 * MS)

    assert (at_first.u, at_first.sample.x) == ((0.0, 0.0), old.x)
    assert (found.sample.x, found.u, found.plant_ns) == (new.x, (4.0, 2.0), 51 * MS)
    assert found.tank_j == pytest.approx(5.0 + 3.0 - 1.0, abs=1e-12)


@pytest.mark.parametrize("phase", PlantPhase)
def test_only_a_plant_that_was_never_driven_has_a_full_tank(phase: PlantPhase) -> None:
    unpredicted = UnpredictedState(Tank(initial_j=3.0, reserve_j=0.5))

    for _ in range(2):  # a plant, and the next one
        unpredicted.confirm(plant_state(0, phase))
        assert unpredicted.at(0).tank_j == (3.0 if phase is PlantPhase.WAITING else 0.5)
        unpredicted.restart()


def test_without_a_state_it_raises() -> None:
    unpredicted = UnpredictedState(Tank())
    unpredicted.confirm(plant_state(0))
    unpredicted.restart()

    with pytest.raises(RuntimeError, match="no plant state"):
        unpredicted.at(0)
