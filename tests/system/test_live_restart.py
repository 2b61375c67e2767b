"""Processes of a running system are killed; the robot stays safe and continues without intervention."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from passafe_protocol.codec import decode
from passafe_protocol.messages import FilterStatus, FilterTick, Header, Message, PlantPhase, PlantState
from passafe_protocol.topics import STATE, TICK, Topic
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.sequence_breaks import sequence_breaks
from passafe_services.tools.review.verdict import Verdict
from running_demo import all_gone, running_demo

pytestmark = pytest.mark.live

PATIENCE_S = 60.0
"""A loaded machine takes long to start a filter again."""


def wait_for(bus: Bus, topic: Topic, wanted: Callable[[Header, Message], bool]) -> Header:
    """Return the header of the first message from now on that is wanted."""
    reader = bus.reader(topic)
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        for header, body in (decode(topic, data) for data in reader.drain()):
            if wanted(header, body):
                return header
        time.sleep(0.01)
    raise AssertionError(f"no such {topic.name} within {PATIENCE_S:g} s")


def passafe(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-P", "-m", "passafe_services.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)


ANSWERS = {FilterStatus.PASSED, FilterStatus.MODIFIED, FilterStatus.RELAXED}


def is_running(_header: Header, body: Message) -> bool:
    return isinstance(body, PlantState) and body.phase is PlantPhase.RUNNING


def is_stopped(_header: Header, body: Message) -> bool:
    return isinstance(body, PlantState) and body.phase is PlantPhase.FAIL_SAFE


def is_fresh(_header: Header, body: Message) -> bool:
    """Check that the filter receives the operator and the plant."""
    return isinstance(body, FilterTick) and body.status in ANSWERS


def test_robot_stays_safe_when_filter_router_and_operator_die(tmp_path: Path) -> None:
    with running_demo(tmp_path, "--restart", "--headless", "--rate", "250") as demo:
        demo.wait_for("running; end with Ctrl-C")
        first = demo.children()
        with open_bus(RouterEndpoint.of_demo(demo.router_port, "recorder")) as bus:
            wait_for(bus, STATE, is_running)

            os.kill(first["filter"], signal.SIGKILL)
            demo.wait_for("filter died: killed by SIGKILL; restarted", timeout_s=5.0)
            stopped = wait_for(bus, STATE, is_stopped)
            wait_for(bus, STATE, lambda header, body: is_running(header, body) and header.sequence > stopped.sequence)

            router = bus.router
            killed = passafe("kill", "router", "--router", demo.router)
            assert killed.stdout == f"killed router (process {first['router']})\n", killed.stderr
            demo.wait_for("router died: killed by SIGKILL; restarted", timeout_s=5.0)
            wait_for(bus, STATE, lambda header, body: bus.router not in {"", router} and is_running(header, body))

            os.kill(first["operator"], signal.SIGKILL)
            demo.wait_for("operator died: killed by SIGKILL; restarted", timeout_s=5.0)
            wait_for(bus, TICK, lambda _, body: isinstance(body, FilterTick) and body.status is FilterStatus.STALE)
            wait_for(bus, TICK, is_fresh)

            last = demo.children()
            wait_for(bus, STATE, is_running)
        demo.process.send_signal(signal.SIGINT)
        code = demo.end()

    assert {name for name in first if last[name] != first[name]} == {"filter", "router", "operator"}
    assert code != 3, demo.lines  # 3: a process died for good
    assert "restarts  filter 1, router 1, operator 1\n" in demo.lines
    assert all_gone([*first.values(), *last.values()], 5.0)

    [path] = tmp_path.glob("*.mcap")
    log = RunLog.read(path)
    assert log.finished
    assert log.counts["state"].gaps == 0  # no moment of the robot is unseen, whatever was down
    verdict = Verdict.of(log, CoreEvaluator(log.identity.scenario))
    assert verdict.sessions == {"operator": 2, "filter": 2, "plant": 1}
    assert verdict.h_min is not None
    assert verdict.h_min >= 0
    assert verdict.properties["safe"].holds
    assert verdict.properties["bounded"].holds
    assert verdict.properties["certified"].holds
    without_input = sequence_breaks(log.of(PlantState))
    assert sum(one.fail_safe_wall_ns is not None for one in without_input) >= 2
    assert all(one.resumed_s is not None for one in without_input)
    assert replay_filter(log).first_difference == ""
