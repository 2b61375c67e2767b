from math import exp

import pytest
from msgspec.structs import replace
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import (
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
from passafe_protocol.topics import TICK
from passafe_services.filter.build import filter_node
from passafe_services.filter.decision_loop import MOST_AT_ONCE, MOST_UNREPORTED
from passafe_services.node import Node, Outgoing
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario

from passafe import SafetyPassivityFilter

MS = 1_000_000
SCENARIO = load_scenario("notomista-cai-2020")
X0 = (2.0, 2.0, -1.0, -1.0)


def make_node() -> Node:
    return filter_node(SCENARIO, "lockstep", 1)


def head(source: str, sequence: int, epoch: int = 1) -> Header:
    return Header(source, epoch, sequence, 0, 0, 0, 0)


def plant_state(
    at_ms: int,
    plant_ms: int = 0,
    x: tuple[float, ...] = X0,
    *,
    phase: PlantPhase = PlantPhase.WAITING,
    epoch: int = 1,
    term: int = 0,
    sequence: int | None = None,
    **fields: object,
) -> Received:
    body = PlantState(plant_ms * MS, x, x[2:], (0.0, 0.0), 0, phase, 0.0, 10.0, 0, 0, 0, 0.0, 0)
    number = at_ms if sequence is None else sequence
    return Received(head("plant", number, epoch), replace(body, **fields), at_ms * MS, term)


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


def ticks_of(node: Node, at_ms: int, *inbox: Received) -> list[FilterTick]:
    return [tick for tick in sent(list(node.step(at_ms * MS, inbox)), FilterTick) if isinstance(tick, FilterTick)]


def tick_of(node: Node, at_ms: int, *inbox: Received) -> FilterTick:
    [tick] = ticks_of(node, at_ms, *inbox)
    return tick


def inputs_of(node: Node, at_ms: int, *inbox: Received) -> list[PlantInput]:
    return [made for made in sent(list(node.step(at_ms * MS, inbox)), PlantInput) if isinstance(made, PlantInput)]


def test_only_scenario_info_is_sent_before_the_first_state() -> None:
    node = make_node()

    first, second = list(node.step(0, [command(0)])), list(node.step(MS, []))

    [info] = sent(first, ScenarioInfo)
    assert isinstance(info, ScenarioInfo)
    assert '"notomista-cai-2020"' in info.scenario_json
    assert [topic.name for topic, _ in first] == ["scenario", "lease"]
    assert second == []


def test_first_tick_lists_everything_consumed_before_it() -> None:
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
    assert (plant_input.input_sequence_start_ns, plant_input.known_break_ns, plant_input.previous_u) == (0, -1, ())
    assert tick.u_h == (-3.0, 0.5)
    assert tick.x_hat == (2.0, 2.0, -1.0, -1.0)
    assert [chain.name for chain in tick.barriers] == ["disk"]
    assert tick.barriers[0].psi[0] == pytest.approx(7.0)
    assert [row.name for row in tick.rows] == ["disk", "passivity"]


def test_a_released_dead_man_fades_and_is_not_stale() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))
    half = ticks_of(node, 52, plant_state(52), command(2, enabled=False))[-1]

    assert half.u_h == (-1.5, 0.25)
    assert half.status is not FilterStatus.STALE
    assert ticks_of(node, 102, plant_state(102))[-1].u_h == (0.0, 0.0)


def test_unpressed_dead_man_gives_zero_and_is_not_stale() -> None:
    node = make_node()

    tick = tick_of(node, 1, plant_state(1), command(1, enabled=False))

    assert tick.u_h == (0.0, 0.0)
    assert tick.status is not FilterStatus.STALE


def test_an_old_command_fades_and_is_stale_until_a_new_one_comes() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))

    old = ticks_of(node, 251, plant_state(251))[-1]
    older = ticks_of(node, 301, plant_state(301))[-1]
    fresh = ticks_of(node, 302, plant_state(302), command(302))[-1]
    fifth = ticks_of(node, 402, plant_state(402), command(402))[-1]

    assert (old.status, old.u_h, old.command_age_ns) == (FilterStatus.STALE, (-1.5, 0.25), 250 * MS)
    assert old.u_h_rate == pytest.approx((30.0, -5.0))
    assert (older.status, older.u_h) == (FilterStatus.STALE, (0.0, 0.0))
    assert fresh.status is not FilterStatus.STALE
    assert (fresh.u_h, fresh.command_state, fresh.command_share) == ((0.0, 0.0), "resumes", 0.0)
    assert fifth.u_h == pytest.approx((-0.6, 0.1))
    assert (fifth.command_state, fifth.command_share) == ("resumes", pytest.approx(0.2))


def test_rows_hold_without_commands_and_status_is_stale() -> None:
    tick = tick_of(make_node(), 1, plant_state(1))

    assert (tick.status, tick.command_age_ns) == (FilterStatus.STALE, -1)
    assert tick.certificate.accepted


def test_an_old_state_stops_the_inputs() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))

    outgoing = list(node.step(300 * MS, [command(150)]))

    assert sent(outgoing, PlantInput) == []
    [tick] = sent(outgoing, FilterTick)
    [event] = sent(outgoing, Event)
    assert isinstance(tick, FilterTick)
    assert isinstance(event, Event)
    assert tick.status is FilterStatus.STALE
    assert "is stale" in event.text


@pytest.mark.parametrize(
    "u_h", [(), (1.0,), (1.0, 2.0, 3.0), (float("nan"), 0.0), (0.0, float("inf")), (float("inf"), float("-inf"))]
)
def test_a_command_that_is_none_is_passed_over(u_h: tuple[float, ...]) -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1, (1.0, 1.0)))

    assert tick_of(node, 2, plant_state(2), command(2, u_h)).u_h == (1.0, 1.0)


def test_reordered_commands_and_other_sessions_are_ignored() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1, (1.0, 1.0), sequence=9))

    assert tick_of(node, 2, plant_state(2), command(2, (2.0, 2.0), sequence=8)).u_h == (1.0, 1.0)
    assert tick_of(node, 3, plant_state(3), command(3, (3.0, 3.0), sequence=0, epoch=2)).u_h == (1.0, 1.0)


def test_a_state_of_another_robot_is_passed_over() -> None:
    node = make_node()

    assert [topic.name for topic, _ in node.step(MS, [plant_state(1, x=(0.0, 0.0, 0.0))])] == ["scenario", "lease"]


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


def test_catch_up_step_emits_one_input_per_skipped_period() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))

    outgoing = list(node.step(5 * MS, [plant_state(5), command(5)]))
    inputs, ticks = sent(outgoing, PlantInput), sent(outgoing, FilterTick)

    assert [made.effective_plant_ns for made in inputs if isinstance(made, PlantInput)] == [MS, 2 * MS, 3 * MS, 4 * MS]
    assert [(tick.tick, tick.u) for tick in ticks if isinstance(tick, FilterTick)] == [
        (made.tick, made.u) for made in inputs if isinstance(made, PlantInput)
    ]
    assert [len(tick.consumed) for tick in ticks if isinstance(tick, FilterTick)] == [2, 0, 0, 0]
    assert [tick.horizon_ns for tick in ticks if isinstance(tick, FilterTick)] == [MS, 2 * MS, 3 * MS, 4 * MS]


def test_inputs_per_step_are_limited_and_the_next_step_continues() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))

    many = inputs_of(node, 101, plant_state(101))
    rest = inputs_of(node, 102, plant_state(102))

    assert [made.effective_plant_ns // MS for made in many] == list(range(1, 1 + MOST_AT_ONCE))
    assert [made.effective_plant_ns // MS for made in rest] == list(range(1 + MOST_AT_ONCE, 102))


def test_without_a_due_input_the_last_decision_is_reported_again() -> None:
    node = make_node()
    first = tick_of(node, 1, plant_state(1), command(1))
    ahead = plant_state(2, 0, phase=PlantPhase.RUNNING, u=first.u, input_epoch=1, input_transit_ns=4 * MS)
    assert len(inputs_of(node, 2, ahead)) == 11  # up to 2 + 4 + 5 ms, play-out time included, instead of 1 ms
    last = ticks_of(node, 3, plant_state(3, 0, phase=PlantPhase.RUNNING, u=first.u))[-1]

    outgoing = list(node.step(3 * MS, [plant_state(4, 0, phase=PlantPhase.RUNNING, u=first.u), command(4)]))

    assert sent(outgoing, PlantInput) == []
    [again] = sent(outgoing, FilterTick)
    assert isinstance(again, FilterTick)
    assert (again.tick, again.u, again.effective_plant_ns) == (last.tick, last.u, last.effective_plant_ns)
    assert [(each.topic, each.sequence) for each in again.consumed] == [("state", 4), ("command", 4)]


def test_nothing_is_sent_while_another_filter_drives_the_plant() -> None:
    node = make_node()
    for k in range(1, 4):
        assert sent(list(node.step(k * MS, [plant_state(k, k, phase=PlantPhase.RUNNING)])), FilterTick) == []

    tick = tick_of(
        node, 4, plant_state(4, 4, phase=PlantPhase.HOLDING, sequence_break_ns=4 * MS, input_since_ns=3 * MS)
    )

    assert [each.sequence for each in tick.consumed] == [1, 2, 3, 4]
    assert tick.effective_plant_ns == (4 + 1 + 5) * MS


def test_a_wait_without_end_fills_no_memory_and_no_message() -> None:
    node = make_node()
    held = 0
    for k in range(1, MOST_UNREPORTED + 500):
        node.step(k * MS, [plant_state(k, k, phase=PlantPhase.RUNNING), command(k)])
        held = max(held, len(node._decisions._unreported))
    at_ms = MOST_UNREPORTED + 500
    broken = plant_state(
        at_ms, at_ms, phase=PlantPhase.HOLDING, sequence_break_ns=at_ms * MS, input_since_ns=at_ms * MS
    )
    tick = tick_of(node, at_ms, broken)

    assert held <= MOST_UNREPORTED + 2
    assert tick.u_h == (-3.0, 0.5)
    assert decode(TICK, encode(head("filter", 1), tick))[1] == tick


def test_restarted_plant_gets_a_new_sequence() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))
    running = plant_state(2, 700, phase=PlantPhase.RUNNING, x=(9.0, 9.0, 0.0, 0.0), sequence_break_ns=5)
    node.step(2 * MS, [running])

    [fresh] = inputs_of(node, 3, plant_state(3, 0, epoch=0, term=1, sequence=0))
    [after] = inputs_of(node, 4, plant_state(4, 800, phase=PlantPhase.RUNNING, epoch=1))

    assert (fresh.effective_plant_ns, fresh.input_sequence_start_ns, fresh.known_break_ns) == (0, 0, -1)
    assert (after.effective_plant_ns, after.input_sequence_start_ns) == (MS, 0)


@pytest.mark.parametrize("plant_ms", [10**9, 2**62 // MS], ids=["days", "centuries"])
def test_plant_time_out_of_reach_is_refused(plant_ms: int) -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1), command(1))
    for k in range(2, 40):
        running = plant_state(k, k, phase=PlantPhase.RUNNING, sequence=2 * k)
        forged = plant_state(k, plant_ms, phase=PlantPhase.RUNNING, sequence=2 * k + 1)
        *_, tick = ticks_of(node, k, running, forged)
        assert tick.state_age_ns == 0
        assert tick.effective_plant_ns < 1_000 * MS


def test_a_state_that_comes_twice_is_no_sign_of_life() -> None:
    node = make_node()
    tick_of(node, 1, plant_state(1, sequence=5), command(1))

    tick = tick_of(node, 250, plant_state(250, sequence=5), command(250))

    assert tick.status is FilterStatus.STALE
    assert tick.state_age_ns == 249 * MS


def test_only_a_plant_at_rest_gets_a_first_input_of_its_own() -> None:
    """The first input of all may be far from zero; a plant that moves has one in force, and u⁺ = u + dt(φ + v)."""
    values = {"filter.start": "nearest", "filter.mode": "off"}
    at_rest, moving = (filter_node(load_scenario(SCENARIO.name, values), "lockstep", 1) for _ in range(2))
    braking = {"phase": PlantPhase.FAIL_SAFE, "u": (9.0, 9.0), "sequence_break_ns": 0}

    first = tick_of(at_rest, 1, plant_state(1), command(1))
    joined = tick_of(moving, 1, plant_state(1, 40, **braking), command(1))

    assert first.u == pytest.approx(first.u_nominal)
    decay = exp(-1e-3) - 9 * (1 - exp(-1e-3))  # of the velocity in one period under u = −9 x₂
    in_force = 9.0 * decay**5
    assert joined.effective_plant_ns == 46 * MS
    assert [u - in_force for u in joined.u] == pytest.approx([1e-3 * phi for phi in joined.phi], abs=1e-9)
    assert max(abs(u - in_force) for u in joined.u) < 5.0 < max(abs(u) for u in first.u)
