"""Stepping a log again that is of a killed filter, or has holes."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from msgspec import structs
from passafe_protocol.messages import FilterTick, Message
from passafe_protocol.topics import TICK
from passafe_services.filter.build import filter_node
from passafe_services.log.continuity import LoggedMessage
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.loop.lockstep import START_NS, Lockstep
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import CompiledScenario, lockstep_loop, period_ns, steps_of
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.run_log import RunLog
from stop_console import StopConsole

BAD_LINKS = {
    "links.filter-to-plant": {"delay_s": 0.01, "jitter_s": 0.02, "loss": 0.1, "seed": 1},
    "links.plant-to-filter": {"delay_s": 0.01, "seed": 2},
}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> RunLog:
    path = tmp_path_factory.mktemp("replay") / "run.mcap"
    scenario = load_scenario("notomista-cai-2020", {"duration_s": 0.5, **BAD_LINKS})
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        lockstep_loop(scenario, LockstepLog(writer)).run(steps_of(scenario))
    return RunLog.read(path)


def test_a_run_with_emergency_stops_replays(tmp_path: Path) -> None:
    scenario = load_scenario("notomista-cai-2020", {"rate_hz": 250.0, **BAD_LINKS})
    compiled, path = CompiledScenario.of(scenario), tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        nodes = [
            plant_node(scenario, compiled.model),
            StopConsole([START_NS + round(at_s * 1e9) for at_s in (0.2, 0.3, 0.6, 0.61)]),
            operator_node(scenario, 1),
            filter_node(scenario, "lockstep", 1, compiled.model, compiled.filter),
        ]
        links = link_settings(scenario)
        Lockstep(nodes, period_ns=period_ns(scenario), links=links, observer=LockstepLog(writer)).run(250)
    log = RunLog.read(path)

    assert {tick.body.status.name for tick in log.of(FilterTick)} >= {"STOPPED", "MODIFIED"}
    assert replay_filter(log).exact


def with_ticks(log: RunLog, keep: Callable[[int], bool]) -> RunLog:
    ticks = [tick for index, tick in enumerate(log.messages[TICK.name]) if keep(index)]
    return replace(log, messages={**log.messages, TICK.name: ticks})


def first_of_a_step_with_several(log: RunLog) -> int:
    due = [tick.header.scheduled_ns for tick in log.of(FilterTick)]
    return next(k for k in range(1, len(due) - 1) if due[k - 1] != due[k] == due[k + 1])


def test_the_whole_log_replays(log: RunLog) -> None:
    assert replay_filter(log).exact


def test_a_last_step_that_was_cut_short_is_no_difference(log: RunLog) -> None:
    last = first_of_a_step_with_several(log)
    result = replay_filter(with_ticks(log, lambda index: index <= last))
    assert result.exact, result
    assert result.ticks == last + 1


def test_step_cut_short_in_the_middle_counts_as_missing(log: RunLog) -> None:
    without = first_of_a_step_with_several(log) + 1
    result = replay_filter(with_ticks(log, lambda index: index != without))
    assert (result.missing, result.first_difference) == (1, "")
    assert result.identical == result.ticks < without
    assert not result.exact


def test_missing_tick_is_reported_as_missing_not_as_different(log: RunLog) -> None:
    result = replay_filter(with_ticks(log, lambda index: index not in {200, 201}))
    assert result.missing == 2
    assert result.identical == result.ticks == 200
    assert not result.exact


def test_tick_missing_in_the_replay_is_a_difference(log: RunLog) -> None:
    ticks: list[LoggedMessage[Message]] = list(log.messages[TICK.name])
    head, body = ticks[-1]
    ticks.append(LoggedMessage(structs.replace(head, sequence=head.sequence + 1), body))
    result = replay_filter(replace(log, messages={**log.messages, TICK.name: ticks}))
    assert result.missing == 0
    assert not result.exact
