"""Ends of a demo: Ctrl-C, a process that dies or leaves, a supervisor that is killed."""

import os
import re
import signal
import time
from pathlib import Path

import pytest
from passafe_protocol.messages import OperatorCommand
from passafe_services.tools.review.run_log import RunLog
from running_demo import all_gone, only_log, running_demo

pytestmark = pytest.mark.live


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


@pytest.mark.alone  # how soon a death is noticed
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
