"""A run without barriers says that nothing was looked at for safety."""

from pathlib import Path

import pytest
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.log_judging import judge_log


@pytest.mark.parametrize(("mode", "is_reported"), [("safe", True), ("both", True), ("passive", False)])
def test_a_verdict_without_barriers_says_so(mode: str, is_reported: bool, tmp_path: Path) -> None:
    scenario = load_scenario("notomista-cai-2020", {"duration_s": 0.1, "filter.mode": mode, "filter.barriers": []})
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(tmp_path / "run.mcap", metadata) as writer:
        loop = lockstep_loop(scenario, LockstepLog(writer))
        loop.run(steps_of(scenario))
        loop.finish()
    verdict = judge_log(tmp_path / "run.mcap").verdict

    assert ("there is no barrier, so nothing was looked at for safety" in verdict.words) is is_reported
