"""Single runs: the metrics are the review's, and depend on nothing but what was asked for."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.experiment.cells import cells_of, run_of
from passafe_services.tools.experiment.kept_logs import REVIEWED
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.metrics import NUMERIC, Metrics
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.run_trace import RunTrace
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict, trajectory_of
from studies import BOTH_WAYS, DELAY, NAME, study

BAD_LINKS = {
    f"links.{name}": {"delay_s": 0.02, "jitter_s": 0.03, "loss": 0.3}
    for name in ("operator-to-filter", "plant-to-filter", "filter-to-plant")
}


def results(swept: Study, runner: StudyRunner | None = None) -> list[RunResult]:
    runner = runner or StudyRunner(swept)
    cells = cells_of(swept.experiment)
    return [
        runner.result(run_of(swept.experiment, cell, seed)) for cell in cells for seed in swept.experiment.seeds.all
    ]


def metrics(swept: Study) -> Metrics:
    [result] = results(swept)
    assert result.metrics is not None, result.error
    return result.metrics


@pytest.mark.parametrize("scenario", [NAME, "walls-and-disks", "moving-disk", "lagged-point", "human-steers"])
@pytest.mark.parametrize("mode", ["off", "both"])
def test_every_metric_is_that_of_a_review_of_the_run_s_log(scenario: str, mode: str, tmp_path: Path) -> None:
    swept = study(scenario, 0.3, overrides=BAD_LINKS | {"filter.mode": mode})
    [result] = results(swept)
    runner, path = StudyRunner(swept), tmp_path / "run.mcap"
    effective = runner.scenario_of(result.run)
    metadata = run_metadata(scenario_json=effective.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as log:
        runner.trace(effective, LockstepLog(log))
    verdict = Verdict.of(RunLog.read(path), CoreEvaluator(effective), derives=False)  # metrics come from the run itself

    assert result.metrics is not None
    assert {name: getattr(result.metrics, name) for name in REVIEWED} == {
        name: getattr(verdict, name) for name in REVIEWED
    }
    held = {name: entry.holds for name, entry in verdict.properties.items()}
    assert held.pop("links-reconciled")  # of a log, not of a run
    assert result.metrics.properties == held
    assert result.metrics.held_s + result.metrics.fail_safe_s == pytest.approx(verdict.without_input_s)
    assert held["complete"]
    assert (result.metrics.steering is not None) == (scenario == "human-steers")


def test_a_run_does_not_depend_on_those_before_it() -> None:
    swept = study(overrides=BAD_LINKS, axes=[DELAY | {"keys": ["plant.playout_s"]}], seeds={"count": 3}, tracking=True)
    runner = StudyRunner(swept)
    first = results(swept, runner)

    again = results(swept, runner)[::-1] + results(swept)[::-1]

    assert [one.metrics for one in again] == [one.metrics for one in first[::-1]] * 2
    assert len({str(one.metrics) for one in first}) == 6


def test_a_run_lasts_as_long_however_late_it_begins() -> None:
    late = metrics(study(overrides=dict.fromkeys(BOTH_WAYS, 0.3)))

    assert late.duration_s == pytest.approx(0.1)
    assert late.properties["complete"] is True
    assert late.verdict == "holds"


def test_a_robot_that_no_input_reaches_proves_nothing() -> None:
    lost = metrics(study(overrides={"links.filter-to-plant.loss": 1.0}))

    assert (lost.duration_s, lost.h_min, lost.final_x, lost.verdict) == (0.0, None, None, "unproven")
    assert lost.properties["complete"] is False


def test_time_in_hold_and_fail_safe_is_what_the_plant_was_in() -> None:
    swept = study(duration_s=0.5, overrides={"links.filter-to-plant.loss": 0.9, "plant.hold_s": 0.005})
    runner = StudyRunner(swept)
    scenario = runner.scenario_of(run_of(swept.experiment, cells_of(swept.experiment)[0], 0))
    phases: list[PlantPhase] = []

    def observe(_topic: object, _header: object, body: object) -> None:
        if isinstance(body, PlantState):
            phases.append(body.phase)

    trace = runner.trace(scenario, observe)
    found = runner.metrics(scenario)

    assert trace.plant_ns == 500_000_000
    moving = [phase for phase in phases if phase is not PlantPhase.WAITING][:-1]
    assert found.fail_safe_s == pytest.approx(moving.count(PlantPhase.FAIL_SAFE) * 1e-3)
    assert found.held_s == pytest.approx(moving.count(PlantPhase.HOLDING) * 1e-3)
    without = [phase is not PlantPhase.RUNNING for phase in phases if phase is not PlantPhase.WAITING]
    assert found.sequence_breaks == sum(now and not before for before, now in pairwise([False, *without])) > 1
    assert min(found.fail_safe_s, found.held_s) > 0.02
    assert found.unserved_share == pytest.approx((found.held_s + found.fail_safe_s) / found.duration_s)


def test_the_trace_holds_what_a_log_holds(tmp_path: Path) -> None:
    scenario = load_scenario(NAME, BAD_LINKS | {"duration_s": 0.1})
    runner, path = StudyRunner(study()), tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as log:
        trace = runner.trace(scenario, LockstepLog(log))
    logged, traced = trajectory_of(RunLog.read(path)), trace.trajectory()

    for name in ("t_s", "x", "u", "energy_in_j", "energy_stored_j", "session", "period_s"):
        assert np.array_equal(getattr(logged, name), getattr(traced, name)), name


def test_a_trace_costs_no_telemetry_and_changes_nothing() -> None:
    scenario = load_scenario(NAME, {"duration_s": 0.05})
    runner = StudyRunner(study())
    compiled = runner._compiled_for(scenario)
    trace = RunTrace(compiled.compiled.filter.core)
    made: list[object] = []
    loop = lockstep_loop(scenario, taps=trace.taps, compiled=compiled.compiled)

    def refuse(_record: object) -> object:
        made.append(_record)
        raise AssertionError("telemetry was made")

    for slot in loop._slots:
        if slot.name == "filter":
            slot.node._decisions._telemetry.message = refuse  # type: ignore[attr-defined]  # slots hold any node
    loop.run(60)

    assert not made
    assert trace.answers().status.size == 60


def test_tracking_is_the_distance_from_the_run_without_links() -> None:
    clean, late = results(study(duration_s=0.5, axes=[DELAY | {"values": [0.0, 0.1]}], tracking=True))

    assert clean.metrics is not None
    assert late.metrics is not None
    assert clean.metrics.tracking_max == clean.metrics.final_error == 0.0
    assert 0.0 < (late.metrics.tracking_rms or 0) < (late.metrics.tracking_max or 0) < 0.5


def test_random_starts_are_safe_and_the_same_in_every_mode() -> None:
    modes = {mode: {"filter.mode": mode} for mode in ("off", "safe", "both")}
    swept = study(start="random", variants=modes, seeds={"count": 2}, axes=[DELAY])
    runner, cells = StudyRunner(swept), cells_of(swept.experiment)
    starts = {
        seed: {runner.scenario_of(run_of(swept.experiment, cell, seed)).plant.x0 for cell in cells} for seed in (0, 1)
    }

    assert len(starts[0]) == len(starts[1]) == 1
    assert starts[0] != starts[1]
    for [x0] in starts.values():
        assert np.hypot(*x0[:2]) > 1.0


def test_every_seed_has_links_of_its_own_unless_one_is_named() -> None:
    link = "links.plant-to-filter"
    swept, fixed = study(overrides={f"{link}.loss": 0.5}), study(overrides={f"{link}.loss": 0.5, f"{link}.seed": 77})

    def seed_of(one: Study, seed: int) -> int:
        run = run_of(one.experiment, cells_of(one.experiment)[0], seed)
        return StudyRunner(one).scenario_of(run).links["plant-to-filter"].seed

    assert [seed_of(swept, seed) for seed in (3, 4)] == [3, 4]
    assert [seed_of(fixed, seed) for seed in (3, 4)] == [77, 77]


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        ({"plant.parameters.sigma": -1.0}, "sigma"),
        ({"plant.start_low": [-0.1, -0.1, 0, 0], "plant.start_high": [0.1, 0.1, 0, 0]}, "plant.start_low"),
        ({"duration_s": -1.0}, "duration_s"),
    ],
)
def test_a_run_that_cannot_be_run_says_why(overrides: dict[str, Any], expected: str) -> None:
    [result] = results(study(start="random", overrides=overrides))

    assert result.metrics is None
    assert expected in result.error
    assert "\n" not in result.error


def test_a_result_survives_its_line_in_a_file() -> None:
    [result] = results(study(overrides={"filter.barriers": []}))

    assert result.metrics is not None
    assert result.metrics.h_min is None
    assert RunResult.model_validate_json(result.model_dump_json()) == result


def test_scores_of_steering_are_metrics_like_others() -> None:
    steered, scripted = metrics(study("human-steers", 3.0)), metrics(study())

    assert steered.steering is not None
    assert steered.number("steering_overshoot") == steered.steering.overshoot
    assert steered.number("steering_effort") == steered.steering.effort
    assert scripted.number("steering_effort") is None
    assert {name: steered.number(name) for name in NUMERIC}["h_min"] == steered.h_min


def test_what_a_criterion_may_ask_about_are_the_numbers() -> None:
    assert {"h_min", "steering_time_to_target_s"} <= set(NUMERIC)
    assert not {"final_x", "status_counts", "properties", "verdict", "h_min_barrier"} & set(NUMERIC)
