"""Golden logs: every decision and every state comes again to the last bit."""

from pathlib import Path

import pytest
from golden_logs import FOLDER, LIVE, SIMULATED, simulate
from passafe_protocol.messages import FilterTick
from passafe_services.tools.replay.replay_log import replay_file
from passafe_services.tools.review.log_judging import judge_log
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.rerun import Conditions
from passafe_services.tools.what_if.what_if import Question

LARGEST_BYTES = 180_000
NAMES = [*SIMULATED, *LIVE]


@pytest.mark.parametrize("name", NAMES)
def test_golden_log_replays(name: str) -> None:
    result = replay_file(FOLDER / f"{name}.mcap")
    assert result.exact, f"{result}: if this is meant, run make golden"


@pytest.mark.parametrize("name", NAMES)
def test_golden_log_holds(name: str) -> None:
    assert judge_log(FOLDER / f"{name}.mcap").verdict.verdict == "holds"


@pytest.mark.parametrize("name", NAMES)
def test_what_if_nothing_changed_is_exact(name: str, tmp_path: Path) -> None:
    question = Question.of(RunLog.read(FOLDER / f"{name}.mcap"))
    result = question.answer(Conditions(scenario=question.run.scenario), tmp_path / "again.mcap")
    assert result.is_exact, f"{result.first_difference}: if this is meant, run make golden"
    assert result.exactness.compared["tick"] == len(question.log.of(FilterTick)) > 20
    assert result.first_difference is None
    assert result.changes == ()


@pytest.mark.campaign
@pytest.mark.parametrize("name", SIMULATED)
def test_simulation_writes_the_golden_log_again(name: str, tmp_path: Path) -> None:
    simulate(name, tmp_path / "again.mcap")
    logged, again = (RunLog.read(path) for path in (FOLDER / f"{name}.mcap", tmp_path / "again.mcap"))
    assert [tick.body for tick in again.of(FilterTick)] == [tick.body for tick in logged.of(FilterTick)]


def test_golden_logs_are_small() -> None:
    sizes = {path.name: path.stat().st_size for path in FOLDER.glob("*.mcap")}
    assert sorted(sizes) == sorted(f"{name}.mcap" for name in NAMES)
    assert max(sizes.values()) < LARGEST_BYTES
