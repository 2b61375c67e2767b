"""Verdict rows of a robot that is not its model: the sets watched, the guard's share, true states judged."""

from pathlib import Path
from typing import Any

import pytest
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.log_judging import judge_log
from passafe_services.tools.review.verdict import Verdict

SETS: dict[str, Any] = {
    "parameters": {"mass": [0.9, 1.1]},
    "disturbance": {"velocity": 0.3},
    "state_error": {"position": 0.001, "velocity": 0.01},
}
TRUTH: dict[str, Any] = {
    "parameters": {"mass": 1.1},
    "disturbance": {"kind": "switching", "bound": {"velocity": 0.3}},
    "noise": {"bound": {"position": 0.001, "velocity": 0.01}},
}


def verdict_of(folder: Path, **overrides: Any) -> Verdict:  # noqa: ANN401 - fields of a scenario
    fields = {"rate_hz": 125.0, "duration_s": 1.2, "filter.mode": "safe"}
    fields |= {key.replace("__", "."): value for key, value in overrides.items()}
    scenario = load_scenario("notomista-cai-2020", fields)
    path = folder / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as log:
        loop = lockstep_loop(scenario, LockstepLog(log))
        loop.run(steps_of(scenario))
        loop.finish()
    return judge_log(path, workers=0).verdict


def test_a_robot_within_its_sets_holds_everything(tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, uncertainty=SETS, plant__truth=TRUTH, plant__guard={})

    assert verdict.verdict == "holds", verdict.words
    model = verdict.properties["model"]
    assert (model.holds, model.required, model.count) == (True, True, 0)
    assert model.worst is not None
    assert 0.1 < model.worst <= 1.0
    assert verdict.guard is not None
    assert verdict.guard.passed > 140
    assert verdict.guard.share < 0.13
    assert "inputs" in verdict.guard.in_words()


def test_a_robot_outside_of_its_sets_fails(tmp_path: Path) -> None:
    narrow = SETS | {"state_error": {"position": 0.0001, "velocity": 0.001}, "in_filter": False}
    verdict = verdict_of(tmp_path, uncertainty=narrow, plant__truth=TRUTH)

    model = verdict.properties["model"]
    assert model.holds is False
    assert model.count is not None
    assert model.count > 100
    assert len(model.violations) == 5
    assert "MODEL_VIOLATED" in verdict.words
    assert verdict.verdict == "fails"
    assert verdict.guard is None


def test_without_sets_there_is_no_such_row(tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, filter__mode="off", plant__guard={})

    assert "model" not in verdict.properties
    assert verdict.guard is not None
    assert verdict.guard.causes == {"disk": verdict.guard.changed}
    assert verdict.guard.changed > 10
    assert verdict.h_min == pytest.approx(0.0, abs=0.2)
    assert verdict.h_min is not None
    assert verdict.h_min >= 0
