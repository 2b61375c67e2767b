"""A page drives a running demo: by the example, until it falls silent, until it hands back to the script."""

import json
import re
import signal
import subprocess
import sys
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest
from lease_watch import wait_for_driver
from passafe_protocol.messages import OperatorCommand, OperatorLease, Steer
from passafe_services.loop.bus import open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.tools.review.run_log import RunLog
from running_demo import running_demo
from websockets.sync.client import ClientConnection, connect

SCRIPT = Path(__file__).parents[2] / "examples" / "drive_client.py"
RATE_HZ = 250
FRESH_NS = 250_000_000
SHARES = [0.25, -0.25]


def receive(page: ClientConnection, kind: str) -> dict[str, Any]:
    while True:
        message: dict[str, Any] = json.loads(page.recv(timeout=30))
        if message["type"] == kind:
            return message


def steer(page: ClientConnection, number: int) -> None:
    clock = {"echo_ms": receive(page, "clock")["server_ms"], "held_ms": 0.0}
    page.send(json.dumps({"type": "steer", "number": number, "shares": SHARES, "engaged": True} | clock))


def drive_by_example(host: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, str(SCRIPT), host], capture_output=True, text=True, timeout=90, check=False)


@pytest.mark.live
@pytest.mark.alone
def test_pages_drive_a_running_demo(tmp_path: Path) -> None:
    options = ("--scenario", "walls-and-disks", "--rate", str(RATE_HZ))
    with running_demo(tmp_path, *options) as demo:
        host = demo.wait_for("page at").split("//")[1].strip().rstrip("/")
        demo.wait_for("running")
        both = [drive_by_example(host) for _ in range(2)]
        with connect(f"ws://{host}/drive") as page:
            page.send('{"type": "take"}')
            while not receive(page, "driver")["you"]:
                pass
            for number in range(10):
                steer(page, number)
            silent = receive(page, "driver")  # nothing more was sent
            page.send('{"type": "script"}')
            back = receive(page, "driver")
        with open_bus(RouterEndpoint.of_demo(demo.router_port, "recorder")) as bus:
            wait_for_driver(bus, "waypoints")
        demo.process.send_signal(signal.SIGINT)
        code = demo.end()

    for done in both:
        assert (done.returncode, done.stdout) == (0, "I drive\n"), done.stderr
    assert (silent["you"], silent["driver"], silent["reason"]) == (False, None, "the page was silent")
    assert back["reason"].startswith("handed to the script by page")
    assert code == 0, "".join(demo.lines)
    assert re.search(r"verdict +holds", "".join(demo.lines))
    [path] = tmp_path.glob("*.mcap")
    judge(RunLog.read(path))


def judge(log: RunLog) -> None:
    """Check in a log who drove when, and that no command of a page drove for longer than it may."""
    commands = log.of(OperatorCommand)
    devices = [device for device, _ in groupby(one.body.device for one in commands)]
    assert devices == ["waypoints", "page", "waypoints"]
    held = [device for device, _ in groupby(lease.body.device for lease in log.of(OperatorLease))]
    assert [device for device in held if device] == devices
    assert sum(one.body.enabled for one in commands if one.body.device == "page") > 2 * RATE_HZ
    steers = [one for one in log.of(Steer) if one.body.engaged]
    assert len({one.body.page for one in steers}) >= 2
    made_ns = [one.header.sent_ns - one.body.age_ns for one in steers]
    period_ns = 10**9 // RATE_HZ
    for one in commands:
        if one.body.device == "page" and one.body.enabled:
            newest = max(made for made in made_ns if made <= one.header.sent_ns)
            assert one.header.scheduled_ns - newest <= FRESH_NS + period_ns
            assert max(map(abs, one.body.u_h)) <= 15.0
