"""``examples/own_operator.py`` takes over a running demo."""

import subprocess
import sys
from pathlib import Path

import pytest
from passafe_protocol.messages import OperatorCommand
from passafe_services.tools.review.run_log import RunLog
from running_demo import running_demo

SCRIPT = Path(__file__).parents[2] / "examples" / "own_operator.py"


@pytest.mark.live
def test_own_operator_drives_a_running_demo(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--headless", "--rate", "250", "--duration", "6") as demo:
        demo.wait_for("running")
        command = [sys.executable, str(SCRIPT), "--port", str(demo.router_port), "--duration", "2"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
        demo.end()

    assert done.returncode == 0, done.stderr
    assert "last seen at (" in done.stdout
    [log] = tmp_path.glob("*.mcap")
    devices = {message.body.device for message in RunLog.read(log).of(OperatorCommand)}
    assert "circle" in devices
