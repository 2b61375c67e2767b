"""Decisions that a review of a run makes again."""

from pathlib import Path

import pytest
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

from passafe import SafetyPassivityFilter
from passafe.decision import Decision

TICKS = 8
TOO_FAST = {"plant.x0": [-2.7, -1.0, -4.0, 0.0]}
"""A start from which a fallback decides every tick, which arrays cannot."""


def test_each_decision_of_a_fallback_is_made_again_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load_scenario("walls-and-disks", TOO_FAST)
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(tmp_path / "run.mcap", metadata) as log:
        loop = lockstep_loop(scenario, observer=LockstepLog(log))
        loop.run(TICKS)
        loop.finish()
    made = []
    decide = SafetyPassivityFilter.decide

    def counted(core: SafetyPassivityFilter, *arguments: object, **options: object) -> Decision:
        made.append(core)
        return decide(core, *arguments, **options)  # type: ignore[arg-type]  # parts of many types

    monkeypatch.setattr(SafetyPassivityFilter, "decide", counted)
    verdict = Verdict.of(RunLog.read(tmp_path / "run.mcap"), CoreEvaluator(scenario))

    assert verdict.properties["decisions-agree"].holds
    assert 0 < len(made) <= 2 * TICKS  # twice if there was no input before
