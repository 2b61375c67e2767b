"""``examples/own_operator.py`` takes over a running demo."""

import signal
import subprocess
import sys
from itertools import groupby
from pathlib import Path

import pytest
from lease_watch import wait_for_driver
from passafe_protocol.messages import OperatorCommand, OperatorLease
from passafe_services.loop.bus import open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.tools.review.run_log import RunLog
from running_demo import running_demo

SCRIPT = Path(__file__).parents[2] / "examples" / "own_operator.py"


@pytest.mark.live
def test_own_operator_drives_a_running_demo(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--headless", "--rate", "250") as demo:
        demo.wait_for("running")
        command = [sys.executable, str(SCRIPT), "--port", str(demo.router_port), "--duration", "2"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
        with open_bus(RouterEndpoint.of_demo(demo.router_port, "recorder")) as bus:
            wait_for_driver(bus, "lag")
        demo.process.send_signal(signal.SIGINT)
        demo.end()

    assert done.returncode == 0, done.stderr
    assert "last seen at (" in done.stdout
    [path] = tmp_path.glob("*.mcap")
    log = RunLog.read(path)
    commands = {(sent.header.epoch, sent.body.device) for sent in log.of(OperatorCommand)}
    assert {device for _, device in commands} == {"circle", "lag"}
    holders = [lease.body.device for lease in log.of(OperatorLease)]
    assert [device for device, _ in groupby(device for device in holders if device)] == ["lag", "circle", "lag"]
