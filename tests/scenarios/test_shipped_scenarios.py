"""Every shipped scenario, for its first seconds: it keeps what its mode asks for, and does what it is there for."""

from pathlib import Path

import numpy as np
import pytest
from passafe_protocol.messages import FilterStatus, FilterTick, PlantInput
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

SHORT_S = 3.0
"""Long enough for every robot to come to its first obstacle."""


def short_run(name: str, folder: Path) -> tuple[RunLog, Verdict]:
    scenario = load_scenario(name, {"duration_s": SHORT_S})
    path = folder / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as log:
        loop = lockstep_loop(scenario, observer=LockstepLog(log))
        loop.run(round(SHORT_S * scenario.rate_hz))
        loop.finish()
    read = RunLog.read(path)
    return read, Verdict.of(read, CoreEvaluator(scenario))


@pytest.mark.parametrize("name", [name for name in shipped_scenarios() if not name.startswith("arm-")])
def test_a_shipped_scenario_holds_and_the_filter_has_to_act(name: str, tmp_path: Path) -> None:
    log, verdict = short_run(name, tmp_path)
    statuses = {tick.body.status for tick in log.of(FilterTick)}

    assert verdict.verdict == "holds", verdict.properties
    assert FilterStatus.MODIFIED in statuses
    assert statuses <= {FilterStatus.PASSED, FilterStatus.MODIFIED, FilterStatus.RELAXED, FilterStatus.STALE}


def test_tight_limits_bind_in_magnitude_and_norm(tmp_path: Path) -> None:
    log, _ = short_run("tight-limits", tmp_path)
    config = load_scenario("tight-limits").filter
    assert config.input_norm_bound is not None
    assert config.input_rate_bound_per_s is not None
    u = np.array([sent.body.u for sent in log.of(PlantInput)])
    rate = np.abs(np.diff(u, axis=0)).max() * load_scenario("tight-limits").rate_hz

    assert np.abs(u).max() == pytest.approx(config.input_bound)
    assert np.linalg.norm(u, axis=1).max() == pytest.approx(config.input_norm_bound, rel=1e-6)
    assert rate <= config.input_rate_bound_per_s


@pytest.mark.parametrize(
    ("name", "kinds", "degrees"),
    [
        ("walls-and-disks", {"room", "disk-keep-out"}, {2}),
        ("moving-disk", {"disk-keep-out"}, {2}),
        ("tight-limits", {"room", "disk-keep-out", "speed-limit"}, {1, 2}),
        ("lagged-point", {"room", "disk-keep-out"}, {3}),
        ("two-robots", {"room", "keep-apart"}, {2}),
    ],
)
def test_shipped_scenarios_cover_relative_degrees_one_to_three(name: str, kinds: set[str], degrees: set[int]) -> None:
    barriers = load_scenario(name).filter.barriers

    assert {barrier.kind for barrier in barriers} == kinds
    assert {len(barrier.class_k) - 1 for barrier in barriers} == degrees
