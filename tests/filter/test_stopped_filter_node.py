"""A filter beside a stopped plant: it sends nothing and says so; after the clear its inputs say that it knew of it."""

import pytest
from passafe_protocol.messages import (
    Event,
    FilterStatus,
    FilterTick,
    Header,
    Message,
    PlantInput,
    PlantPhase,
    PlantState,
    Received,
)
from passafe_services.filter.build import filter_node
from passafe_services.node import Node
from passafe_services.scenarios.load import load_scenario

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)


def state(at_ms: int, plant_ms: int, *, phase: PlantPhase, stop: int = 0, cleared: int = 0) -> Received:
    body = PlantState(
        plant_ms * MS, X0, X0[2:], (0.5, 0.25), 0, phase, 0.0, 10.0, 0, 0, 0, 0.0, 0,
        stop=stop, stop_source="console" if stop else "", stops_cleared=cleared,
        sequence_break_ns=plant_ms * MS if phase is PlantPhase.FAIL_SAFE else -1,
    )  # fmt: skip
    return Received(Header("plant", 1, at_ms, at_ms * MS, 0, 0, 0), body, at_ms * MS)


def step(node: Node, at_ms: int, *inbox: Received) -> list[Message]:
    return [body() if callable(body) else body for _, body in node.step(at_ms * MS, inbox)]


def inputs(bodies: list[Message]) -> list[PlantInput]:
    return [body for body in bodies if isinstance(body, PlantInput)]


@pytest.fixture(params=[True, False], ids=["predicted", "unpredicted"])
def node(request: pytest.FixtureRequest) -> Node:
    return filter_node(load_scenario("notomista-cai-2020", {"filter.prediction": request.param}), "lockstep", 1)


def test_it_sends_nothing_while_the_plant_is_stopped(node: Node) -> None:
    [before] = inputs(step(node, 1, state(1, 0, phase=PlantPhase.WAITING)))
    found = [step(node, at_ms, state(at_ms, at_ms, phase=PlantPhase.FAIL_SAFE, stop=8)) for at_ms in range(2, 1_200)]

    assert before.stops_cleared == 0
    assert not any(map(inputs, found))
    ticks = [body for bodies in found for body in bodies if isinstance(body, FilterTick)]
    assert {tick.status for tick in ticks} == {FilterStatus.STOPPED}
    text = "an emergency stop is latched at the plant: nothing is sent until it is cleared there"
    assert [body for bodies in found for body in bodies if isinstance(body, Event)] == [Event("warning", text)]


def test_after_the_clear_its_inputs_know_of_it(node: Node) -> None:
    step(node, 1, state(1, 0, phase=PlantPhase.WAITING))
    step(node, 2, state(2, 2, phase=PlantPhase.FAIL_SAFE, stop=8))

    sent = [
        each
        for at_ms in range(3, 20)
        for each in inputs(step(node, at_ms, state(at_ms, at_ms, phase=PlantPhase.FAIL_SAFE, cleared=1)))
    ]

    assert sent
    assert {each.stops_cleared for each in sent} == {1}


def test_a_filter_that_starts_beside_a_stopped_plant_waits(node: Node) -> None:
    found = [step(node, at_ms, state(at_ms, 0, phase=PlantPhase.WAITING, stop=8)) for at_ms in range(1, 50)]

    assert not any(map(inputs, found))
    [sent] = inputs(step(node, 50, state(50, 0, phase=PlantPhase.WAITING, cleared=1)))
    assert (sent.stops_cleared, sent.effective_plant_ns) == (1, 0)
