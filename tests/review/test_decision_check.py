"""Decisions that a review of a run makes again."""

from pathlib import Path

import pytest
from changed_logs import recorded, verdict_on
from passafe_services.scenarios.load import load_scenario
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
    recorded(tmp_path / "run.mcap", scenario, steps=TICKS)
    made = []
    decide = SafetyPassivityFilter.decide

    def counted(core: SafetyPassivityFilter, *arguments: object, **options: object) -> Decision:
        made.append(core)
        return decide(core, *arguments, **options)  # type: ignore[arg-type]  # parts of many types

    monkeypatch.setattr(SafetyPassivityFilter, "decide", counted)
    verdict = Verdict.of(RunLog.read(tmp_path / "run.mcap"), CoreEvaluator(scenario))

    assert verdict.properties["decisions-agree"].holds
    assert 0 < len(made) <= 2 * TICKS  # twice if there was no input before


@pytest.mark.parametrize("rate_hz", [120.0, 700.0])
def test_period_of_no_whole_nanoseconds_is_no_difference(rate_hz: float, tmp_path: Path) -> None:
    recorded(tmp_path / "run.mcap", load_scenario("walls-and-disks", {"rate_hz": rate_hz}), steps=100)

    assert verdict_on(tmp_path / "run.mcap").words == "holds"
