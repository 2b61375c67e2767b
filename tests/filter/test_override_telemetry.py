from collections.abc import Iterator
from itertools import pairwise

import pytest
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import CommandState, Event, FilterStatus, FilterTick, Header
from passafe_protocol.topics import TICK
from passafe_services.filter.operator_request import OperatorRequest
from passafe_services.filter.telemetry import Telemetry, TickRecord
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.robot_models import ROBOT_MODELS
from passafe_services.simulation import lockstep_loop

from passafe.decision import Status
from passafe.filter import SafetyPassivityFilter
from passafe.override import Explainer
from passafe.program.infeasibility import DistanceToInfeasibility

SCENARIO = load_scenario("notomista-cai-2020")
CORE = SafetyPassivityFilter(design_of(SCENARIO, robot_of(SCENARIO)))
HEADER = Header("filter", 1, 1, 0, 0, 0, 0)


def tick_at(x: tuple[float, ...], u_h: tuple[float, float], core: SafetyPassivityFilter = CORE) -> FilterTick:
    decision = core.decide(x, (0.0, 0.0), u_h, (0.0, 0.0), 1.0, start=True)
    status, request = (
        FilterStatus[decision.status.name],
        OperatorRequest(u_h, (0.0, 0.0), 30, CommandState.RESUMES, 0.25),
    )
    tick = TickRecord(Telemetry(core, Explainer(core)), 1, status, decision, decision, 0, 1.0, (), 20, request, 7)()
    assert decode(TICK, encode(HEADER, tick))[1] == tick
    assert (tick.state_age_ns, tick.command_age_ns, tick.horizon_ns) == (20, 30, 7)
    assert (tick.command_state, tick.command_share) == ("resumes", 0.25)
    return tick


def test_tick_contains_the_cores_decision() -> None:
    x, u_h = (1.2, 0.0, -1.0, 0.0), (-30.0, 0.0)
    decision = CORE.decide(x, (0.0, 0.0), u_h, (0.0, 0.0), 1.0, start=True)
    override = Explainer(CORE).override(decision)
    distance = DistanceToInfeasibility(CORE.design.limits, 1).of(decision)

    tick = tick_at(x, u_h)

    assert decision.status is not Status.PASSED
    assert tick.override.held_back == tuple(override.held_back)
    assert (tick.override.allowed_fraction, tick.override.unavoidable) == (
        override.allowed_fraction,
        override.unavoidable,
    )
    assert tick.override.distance_to_infeasibility == distance.lower
    assert {row.name: row.share for row in tick.rows if row.active} == {c.row: c.share for c in override.causes}
    assert tick.barriers[0].eps == decision.part("eps")[0] > 0.0
    assert [row.relaxed for row in tick.rows] == [0.0] * len(tick.rows)


def test_limit_that_clips_the_request_is_listed_with_zero_dual() -> None:
    scenario = load_scenario("notomista-cai-2020", {"filter.mode": "safe"})
    tick = tick_at((2.0, 2.0, 0.0, 0.0), (500.0, 0.0), SafetyPassivityFilter(design_of(scenario, robot_of(scenario))))

    [limit] = [row for row in tick.rows if row.name == "input 0 high"]
    assert limit.active
    assert limit.dual == 0.0
    assert limit.share == pytest.approx(1.0, abs=1e-3)


def test_relaxed_rows_report_amounts_and_unenforced_rows_none() -> None:
    scenario = load_scenario("notomista-cai-2020")
    narrow = scenario.model_copy(update={"filter": scenario.filter.model_copy(update={"input_bound": 1.0})})
    given_up = tick_at((1.1, 0.0, -3.0, 0.0), (0.0, 0.0), SafetyPassivityFilter(design_of(narrow, robot_of(narrow))))
    passive = scenario.model_copy(update={"filter": scenario.filter.model_copy(update={"mode": "passive"})})
    core = SafetyPassivityFilter(design_of(passive, robot_of(passive)))
    unenforced = tick_at((1.1, 0.0, -3.0, 0.0), (0.0, 0.0), core)

    assert given_up.status is FilterStatus.INFEASIBLE
    assert given_up.rows[0].relaxed > 1.0
    assert given_up.override.distance_to_infeasibility == pytest.approx(-given_up.rows[0].relaxed, rel=1e-3)
    assert unenforced.barriers[0].eps == 0.0
    assert unenforced.override.distance_to_infeasibility == core.design.limits.reach


def test_override_causes_are_reported_at_most_once_a_second() -> None:
    received: list[tuple[int, str]] = []

    def listen(*message: object) -> None:
        received.extend(events(message))

    def events(message: tuple[object, ...]) -> Iterator[tuple[int, str]]:
        [header] = [part for part in message if isinstance(part, Header)]
        yield from ((header.scheduled_ns, part.text) for part in message if isinstance(part, Event))

    lockstep_loop(SCENARIO, listen).run(4000)

    reported = [(at_ns, text) for at_ns, text in received if text.startswith("held back")]
    assert any("m/s²: obstacle `disk`, " in text for _, text in reported)
    assert all(later - earlier >= 1_000_000_000 for (earlier, _), (later, _) in pairwise(reported))


def test_robot_model_gives_the_input_its_unit() -> None:
    assert SCENARIO.plant.robot_model.input_unit == "m/s²"
    assert ROBOT_MODELS["joint-chain"].input_unit == "rad/s²"
