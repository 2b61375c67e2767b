"""The whole system as processes over Zenoh, as a user runs it."""

import os
import re
import signal
import time
from pathlib import Path

import pytest
from passafe_protocol.messages import FilterTick, OperatorCommand, PlantState, ScenarioInfo
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from running_demo import all_gone, running_demo

pytestmark = pytest.mark.live


def only_log(folder: Path) -> Path:
    [log] = [path for path in folder.glob("*.mcap") if not path.name.endswith(".torn.mcap")]
    return log


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


def test_ctrl_c_ends_with_the_verdict_and_leaves_nothing_behind(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--headless") as demo:
        demo.wait_for("running; end with Ctrl-C")
        pids = list(demo.children().values())
        demo.process.send_signal(signal.SIGINT)
        demo.end()

    assert len(pids) == 5
    assert all_gone(pids, 5.0)
    assert any(line.startswith("verdict") for line in demo.lines)
    assert RunLog.read(only_log(tmp_path)).finished


@pytest.mark.parametrize("victim", ["router", "recorder", "dashboard", "operator", "filter", "plant"])
def test_killed_process_is_named_and_the_log_is_readable(victim: str, tmp_path: Path) -> None:
    with running_demo(tmp_path, "--rate", "1000") as demo:
        demo.wait_for("running; end with Ctrl-C")
        pids = demo.children()
        os.kill(pids[victim], signal.SIGKILL)
        killed = time.monotonic()
        demo.wait_for(f"{victim} died: killed by SIGKILL", timeout_s=5.0)
        noticed_s = time.monotonic() - killed
        code = demo.end()

    assert len(pids) == 6
    assert noticed_s < 1.0
    assert code != 0
    assert all_gone(list(pids.values()), 5.0)
    assert RunLog.read(only_log(tmp_path)).of(OperatorCommand)  # killed at once, it may have flushed no tick yet
    assert not any("Traceback" in line for line in demo.lines)


def test_nothing_outlives_a_killed_supervisor(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--headless") as demo:
        demo.wait_for("running; end with Ctrl-C")
        pids = list(demo.children().values())
        demo.process.send_signal(signal.SIGKILL)

        assert all_gone(pids, 15.0)


def test_a_filter_that_leaves_before_the_end_leaves_no_whole_run(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--duration", "30", "--rate", "200", "--headless") as demo:
        demo.wait_for("running for 30 s")
        os.kill(demo.children()["filter"], signal.SIGTERM)
        code = demo.end()

    text = "".join(demo.lines)
    assert code == 3
    assert "filter ended: exit code 0" in text
    assert re.search(r"verdict   unproven: .*not a whole run: it ended after [\d.]+ s of 30 s", text)
