import pytest

from passafe import SafetyPassivityFilter
from protocol.messages import (
    Event,
    FilterStatus,
    FilterTick,
    Header,
    OperatorCommand,
    PlantInput,
    PlantPhase,
    PlantState,
    Received,
    ScenarioInfo,
)
from services.assembly import filter_node
from services.filter.node import FilterNode
from services.filter.telemetry import Telemetry
from services.runtime.node import Outgoing
from services.scenarios.design import design_of, robot_of
from services.scenarios.load import load_scenario

MS = 1_000_000
SCENARIO = load_scenario("notomista-cai-2020")


def make_node() -> FilterNode:
    return filter_node(SCENARIO, "lockstep")


def head(source: str, sequence: int, epoch: int = 1) -> Header:
    return Header(source, epoch, sequence, 0, 0, 0, 0)


def plant_state(at_ms: int, plant_ms: int = 0, x: tuple[float, ...] = (2.0, 2.0, -1.0, -1.0)) -> Received:
    body = PlantState(plant_ms * MS, x, x[2:], (0.0, 0.0), 0, PlantPhase.WAITING, 0.0, 10.0, 0, 0, 0, 0.0, 0)
    return Received(head("plant", at_ms), body, at_ms * MS)


def command(
    at_ms: int,
    u_h: tuple[float, ...] = (-3.0, 0.5),
    *,
    enabled: bool = True,
    rate: tuple[float, ...] = (),
    epoch: int = 1,
    sequence: int | None = None,
) -> Received:
    number = at_ms if sequence is None else sequence
    return Received(head("operator", number, epoch), OperatorCommand(u_h, rate, enabled, "test"), at_ms * MS)


def sent(outgoing: list[Outgoing], kind: type) -> list[object]:
    made = [body() if callable(body) else body for _, body in outgoing]
    return [body for body in made if isinstance(body, kind)]


def tick_of(node: FilterNode, at_ms: int, *inbox: Received) -> FilterTick:
    [tick] = sent(list(node.step(at_ms * MS, inbox)), FilterTick)
    assert isinstance(tick, FilterTick)
    return tick


def test_before_the_first_state_it_says_what_it_runs_and_nothing_else() -> None:
    node = make_node()

    first, second = list(node.step(0, [command(0)])), list(node.step(MS, []))

    [info] = sent(first, ScenarioInfo)
    assert isinstance(info, ScenarioInfo)
    assert '"notomista-cai-2020"' in info.scenario_json
    assert (len(first), second) == (1, [])


def test_the_first_tick_accounts_for_everything_consumed_before_it() -> None:
    node = make_node()
    node.step(0, [command(0)])

    tick = tick_of(node, 1, plant_state(1), command(1))

    assert [(c.topic, c.sequence) for c in tick.consumed] == [("command", 0), ("state", 1), ("command", 1)]


def test_a_tick_sends_the_input_that_it_tells_of() -> None:
    node = make_node()
    outgoing = list(node.step(MS, [plant_state(1), command(1)]))

    [plant_input], [tick] = sent(outgoing, PlantInput), sent(outgoing, FilterTick)

    assert isinstance(plant_input, PlantInput)
    assert isinstance(tick, FilterTick)
    assert (plant_input.tick, plant_input.u, plant_input.effective_plant_ns) == (1, tick.u, 0)
    assert tick.u_h == (-3.0, 0.5)
    assert tick.x_hat == (2.0, 2.0, -1.0, -1.0)
    assert [chain.name for chain in tick.barriers] == ["disk"]
    assert tick.barriers[0].psi[0] == pytest.approx(7.0)
    assert [row.name for row in tick.rows] == ["disk", "passivity"]


def test_a_released_dead_man_counts_as_zero_and_is_not_stale() -> None:
    node = make_node()

    tick = tick_of(node, 1, plant_state(1), command(1, enabled=False))

    assert tick.u_h == (0.0, 0.0)
    assert tick.status is not FilterStatus.STALE


def test_an_old_command_counts_as_zero_and_is_stale_until_a_new_one_comes() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))

    old = tick_of(node, 202, plant_state(202))
    fresh = tick_of(node, 203, plant_state(203), command(203))

    assert (old.status, old.u_h, old.command_age_ns) == (FilterStatus.STALE, (0.0, 0.0), 201 * MS)
    assert fresh.status is not FilterStatus.STALE
    assert fresh.u_h == (-3.0, 0.5)


def test_without_any_command_the_rows_are_kept_and_the_status_is_stale() -> None:
    tick = tick_of(make_node(), 1, plant_state(1))

    assert (tick.status, tick.command_age_ns) == (FilterStatus.STALE, -1)
    assert tick.certificate.accepted


def test_an_old_state_stops_the_inputs() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))

    outgoing = list(node.step(300 * MS, [command(300)]))

    assert sent(outgoing, PlantInput) == []
    [tick] = sent(outgoing, FilterTick)
    [event] = sent(outgoing, Event)
    assert isinstance(tick, FilterTick)
    assert isinstance(event, Event)
    assert tick.status is FilterStatus.STALE
    assert "not been heard of" in event.text


@pytest.mark.parametrize(
    "u_h", [(), (1.0,), (1.0, 2.0, 3.0), (float("nan"), 0.0), (0.0, float("inf")), (float("inf"), float("-inf"))]
)
def test_a_command_that_is_none_is_passed_over(u_h: tuple[float, ...]) -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1, (1.0, 1.0)))

    assert tick_of(node, 2, plant_state(2), command(2, u_h)).u_h == (1.0, 1.0)


def test_an_overtaken_command_is_passed_over_and_a_newer_session_counts() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1, (1.0, 1.0), sequence=9))

    assert tick_of(node, 2, plant_state(2), command(2, (2.0, 2.0), sequence=8)).u_h == (1.0, 1.0)
    assert tick_of(node, 3, plant_state(3), command(3, (3.0, 3.0), sequence=0, epoch=2)).u_h == (3.0, 3.0)


def test_a_state_of_another_robot_is_passed_over() -> None:
    node = make_node()

    assert list(node.step(MS, [plant_state(1, x=(0.0, 0.0, 0.0))]))[1:] == []


def test_telemetry_agrees_with_the_decision() -> None:
    core = SafetyPassivityFilter(design_of(SCENARIO, robot_of(SCENARIO)))
    node = make_node()

    tick = tick_of(node, 1, plant_state(1), command(1, rate=(-15.0, 0.0)))
    decision = core.decide((2.0, 2.0, -1.0, -1.0), (0.0, 0.0), (-3.0, 0.5), (-15.0, 0.0), 1.0)

    assert tick.u == decision.u
    assert tick.v == tuple(decision.v)
    assert tick.phi == tuple(decision.phi)
    assert tick.u_nominal == tuple(decision.u_nominal)
    assert tick.power_margin == decision.power_margin
    assert [row.margin for row in tick.rows] == list(decision.margins[:2])
    assert isinstance(Telemetry(core), Telemetry)
