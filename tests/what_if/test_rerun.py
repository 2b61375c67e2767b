"""Re-runs of logs in virtual time: what changes, what stays, and what explains it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from mcap.records import Metadata
from passafe_protocol.messages import FilterTick, OperatorCommand, PlantState
from passafe_protocol.topics import STATE, TICK
from passafe_services.filter.build import filter_node
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.loop.lockstep import START_NS, Lockstep
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import CompiledScenario, lockstep_loop, period_ns, steps_of
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.errors import RerunError
from passafe_services.tools.what_if.rerun import Conditions
from passafe_services.tools.what_if.what_if import OPEN_LOOP, WHAT_IF_RECORD, Question, WhatIf

GOLDEN = Path(__file__).parents[1] / "golden"
SHORT: Mapping[str, Any] = {"rate_hz": 125.0, "duration_s": 0.4}


def simulated(path: Path, scenario: Scenario) -> RunLog:
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        loop = lockstep_loop(scenario, LockstepLog(writer))
        loop.run(steps_of(scenario))
        loop.finish()
    return RunLog.read(path)


def changed(scenario: Scenario, **overrides: Any) -> Scenario:  # noqa: ANN401 - any value of a scenario
    return scenario_from(
        scenario.model_dump(mode="json"), "test", {k.replace("__", "."): v for k, v in overrides.items()}
    )


def asked(log: RunLog, out: Path, scenario: Scenario, **how: Any) -> WhatIf:  # noqa: ANN401 - any condition
    return Question.of(log).answer(Conditions(scenario=scenario, **how), out)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> RunLog:
    return simulated(tmp_path_factory.mktemp("what-if") / "run.mcap", load_scenario("notomista-cai-2020", SHORT))


def test_delay_of_a_link_explains_a_late_tick(log: RunLog, tmp_path: Path) -> None:
    slow = changed(log.identity.scenario, **{"links.plant-to-filter": {"delay_s": 0.152}})
    result = asked(log, tmp_path / "slow.mcap", slow)
    assert result.changes == ("links.plant-to-filter.delay_s 0 -> 0.152",)
    first = result.first_difference
    assert first is not None
    assert first.text == "tick 1: sent 0.152 s later, age of state 0.152 s instead of 0 s"
    assert first.cause == "link plant-to-filter: links.plant-to-filter.delay_s 0 -> 0.152"


def test_planned_delay_explains_the_age_of_a_state(log: RunLog, tmp_path: Path) -> None:
    planned = [{"at_s": 0.2, "link": "plant-to-filter", "settings": {"delay_s": 0.04}}]
    result = asked(log, tmp_path / "later.mcap", changed(log.identity.scenario, link_changes=planned))
    first = result.first_difference
    assert first is not None
    assert first.at_s == pytest.approx(0.2)
    assert first.text == "tick 26: age of state 0.008 s instead of 0 s"
    assert first.cause.startswith("link plant-to-filter: link_changes")


def test_gain_explains_an_input(log: RunLog, tmp_path: Path) -> None:
    result = asked(log, tmp_path / "gain.mcap", changed(log.identity.scenario, filter__k_i=5.0))
    assert result.first_difference is not None
    assert result.first_difference.message == "input of tick 1"
    assert result.first_difference.cause == "filter.k_i 100 -> 5"
    assert result.first_motion is not None


def test_mass_of_the_robot_explains_its_motion(log: RunLog, tmp_path: Path) -> None:
    heavy = changed(log.identity.scenario, plant__x0=[2.0, 2.0, -1.0, -0.5])
    result = asked(log, tmp_path / "start.mcap", heavy)
    assert result.first_difference is not None
    assert result.first_difference.text.startswith("state 0: x[3] -1.0 -> -0.5, ")
    assert result.first_difference.cause == "plant.x0.3 -1 -> -0.5"


def test_commands_stay_those_of_the_log(log: RunLog, tmp_path: Path) -> None:
    result = asked(log, tmp_path / "off.mcap", changed(log.identity.scenario, filter__mode="off"))
    assert result.operator == OPEN_LOOP
    again = RunLog.read(tmp_path / "off.mcap")
    assert [each.body for each in again.of(OperatorCommand)] == [each.body for each in log.of(OperatorCommand)]
    assert {tick.body.mode for tick in again.of(FilterTick)} == {"off"}


def test_log_of_a_what_if_says_what_it_was_made_from(log: RunLog, tmp_path: Path) -> None:
    out = tmp_path / "out.mcap"
    result = asked(log, out, changed(log.identity.scenario, filter__k_i=5.0))
    [shown] = [r.metadata for r in LogReader(out).records() if isinstance(r, Metadata) and r.name == WHAT_IF_RECORD]
    assert shown["source_digest"] == result.source_digest
    assert shown["operator"] == OPEN_LOOP
    assert '"filter.k_i"' in shown["changes"]
    again = Question.of(RunLog.read(out))
    assert again.answer(Conditions(scenario=again.run.scenario), tmp_path / "twice.mcap").is_exact


@pytest.mark.parametrize("name", ["live", "live-bad-links"])
def test_what_if_of_a_live_log_is_exact_itself(name: str, tmp_path: Path) -> None:
    log = RunLog.read(GOLDEN / f"{name}.mcap")
    asked(log, tmp_path / "first.mcap", changed(log.identity.scenario, filter__k_i=5.0))
    first = RunLog.read(tmp_path / "first.mcap")

    result = asked(first, tmp_path / "second.mcap", first.identity.scenario)

    assert result.first_difference is None
    assert result.is_exact
    assert RunLog.read(tmp_path / "second.mcap").identity.timing == "live"


def test_script_under_a_delay_is_the_run_recorded_under_it(log: RunLog, tmp_path: Path) -> None:
    delayed = changed(log.identity.scenario, **{"links.plant-to-filter": {"delay_s": 0.152}})
    recorded = simulated(tmp_path / "recorded.mcap", delayed)
    asked(log, tmp_path / "asked.mcap", delayed, operator_acts=True)
    again = RunLog.read(tmp_path / "asked.mcap")
    for body in (FilterTick, PlantState):
        assert [each.body for each in again.of(body)] == [each.body for each in recorded.of(body)]


def test_links_drawn_anew_lose_other_messages(tmp_path: Path) -> None:
    log = RunLog.read(GOLDEN / "bad-links.mcap")
    result = asked(log, tmp_path / "drawn.mcap", log.identity.scenario, links="drawn", seed=9)
    assert result.links == "drawn anew, seed 9"
    assert not result.is_exact
    assert result.first_difference is not None
    assert "links: drawn anew, seed 9" in result.first_difference.cause


def test_live_log_under_another_delay(tmp_path: Path) -> None:
    log = RunLog.read(GOLDEN / "live.mcap")
    slow = changed(log.identity.scenario, **{"links.plant-to-filter": {"delay_s": 0.05}})
    result = asked(log, tmp_path / "slow.mcap", slow)
    assert result.first_difference is not None
    assert "link plant-to-filter" in result.first_difference.cause
    ages = [tick.body.state_age_ns for tick in RunLog.read(tmp_path / "slow.mcap").of(FilterTick)]
    assert min(ages) >= 50_000_000


def test_live_log_at_another_rate_or_by_another_operator(tmp_path: Path) -> None:
    log = RunLog.read(GOLDEN / "live.mcap")
    source = {"kind": "constant", "value": [1.0, 0.0]}
    driven = changed(log.identity.scenario, rate_hz=200.0, operator__source=source)
    asked(log, tmp_path / "driven.mcap", driven, operator_acts=True)
    again = RunLog.read(tmp_path / "driven.mcap")
    assert {each.body.u_h for each in again.of(OperatorCommand)} == {(1.0, 0.0)}
    assert len(again.of(PlantState)) > len(log.of(PlantState))


def test_killed_filter_is_killed_again(tmp_path: Path) -> None:
    scenario = load_scenario("notomista-cai-2020", SHORT)
    compiled, path = CompiledScenario.of(scenario), tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        nodes = [
            plant_node(scenario, compiled.model),
            operator_node(scenario, 1),
            filter_node(scenario, "lockstep", 1, compiled.model, compiled.filter),
        ]
        loop = Lockstep(
            nodes, period_ns=period_ns(scenario), links=link_settings(scenario), observer=LockstepLog(writer)
        )
        loop.run(20)
        loop.kill("filter")
        loop.run(10)
        loop.restart(filter_node(scenario, "lockstep", 2, compiled.model, compiled.filter), 2)
        loop.run(25)
    log = RunLog.read(path)
    assert {tick.header.epoch for tick in log.of(FilterTick)} == {1, 2}
    assert log.of(FilterTick)[0].header.scheduled_ns == START_NS
    assert asked(log, tmp_path / "again.mcap", scenario).is_exact


def test_log_that_begins_in_motion_is_refused(log: RunLog, tmp_path: Path) -> None:
    torn = tmp_path / "late.mcap"
    metadata = run_metadata(scenario_json=log.identity.scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(torn, metadata) as writer:
        write = LockstepLog(writer)
        for topic, messages in ((STATE, log.of(PlantState)[20:]), (TICK, log.of(FilterTick)[20:])):
            for header, body in messages:
                write(topic, header, body)
    with pytest.raises(RerunError, match=r"got plant time .* s first, allowed 0"):
        Question.of(RunLog.read(torn))


def test_log_without_ticks_is_refused(log: RunLog, tmp_path: Path) -> None:
    empty = tmp_path / "empty.mcap"
    metadata = run_metadata(scenario_json=log.identity.scenario.model_dump_json(), versions={}, driver="lockstep")
    LogWriter(empty, metadata).close()
    with pytest.raises(RerunError, match=r"no states of the plant or no ticks"):
        Question.of(RunLog.read(empty))
