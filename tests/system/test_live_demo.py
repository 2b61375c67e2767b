"""The whole system as processes over Zenoh, as a user runs it."""

import pytest
from passafe_protocol.messages import FilterTick, OperatorCommand, PlantState, ScenarioInfo
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from running_demo import only_log, running_demo

pytestmark = [pytest.mark.live, pytest.mark.alone]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunLog, list[str], int]:
    folder = tmp_path_factory.mktemp("live")
    with running_demo(folder, "--duration", "3", "--rate", "1000") as demo:
        demo.wait_for(r"dashboard http://127\.0\.0\.1:\d+/")
        code = demo.end()
    return RunLog.read(only_log(folder)), demo.lines, code


def test_live_run_ends_with_a_verdict_and_the_path_of_the_log(
    finished: tuple[RunLog, list[str], int],
) -> None:
    log, lines, code = finished
    text = "".join(lines)

    assert code == 0, text
    assert "verdict   holds" in text
    assert str(log.path) in text
    assert log.finished


def test_a_live_log_shows_a_safe_and_passive_run(finished: tuple[RunLog, list[str], int]) -> None:
    log, _, _ = finished
    verdict = Verdict.of(log, CoreEvaluator(log.identity.scenario))

    assert verdict.duration_s == pytest.approx(3.0, abs=0.1)
    assert verdict.h_min is not None
    assert verdict.power_margin_min is not None
    assert verdict.h_min >= -1e-3
    assert verdict.power_margin_min >= -0.05
    assert verdict.solve_us_p50 is not None
    assert verdict.solve_us_p50 > 0
    assert {"PASSED", "MODIFIED"} <= set(verdict.status_counts)


def test_a_live_log_is_complete(finished: tuple[RunLog, list[str], int]) -> None:
    log, _, _ = finished

    assert all(log.of(kind) for kind in (OperatorCommand, PlantState, FilterTick))
    assert {name: log.counts[name].gaps for name in ("command", "state", "tick", "input")} == {
        "command": 0,
        "state": 0,
        "tick": 0,
        "input": 0,
    }


def test_filter_repeats_its_scenario_for_late_joiners(finished: tuple[RunLog, list[str], int]) -> None:
    log, _, _ = finished
    scenarios = [message.body.scenario_json for message in log.of(ScenarioInfo)]

    assert len(scenarios) >= 3
    assert set(scenarios) == {log.identity.scenario.model_dump_json()}


def test_the_filter_of_a_live_run_replays_to_the_last_bit(finished: tuple[RunLog, list[str], int]) -> None:
    result = replay_filter(finished[0])

    assert result.exact, result
