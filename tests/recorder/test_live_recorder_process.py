"""The recorder as a process on a real bus."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Timer

import pytest
from passafe_protocol.codec import decode
from passafe_protocol.messages import Event, Health, TopicHealth
from passafe_protocol.topics import EVENT, HEALTH
from passafe_services.log.continuity import TopicCount
from passafe_services.loop.bus import TopicReader, open_bus
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.readiness import ready_line
from passafe_services.loop.receipts import Receipts
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.run_log import RunLog

ROOT = Path(__file__).parents[2]
PATIENCE_S = 30.0
MESSAGES = 3000

ROUTER = """
import sys
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.router.process import run_router
run_router(RouterEndpoint(port=int(sys.argv[1])), lifeline=True)
"""
RECORDER = """
import sys
from pathlib import Path
from passafe_services.log.errors import LogFileError
from passafe_services.log.log_writer import run_metadata
from passafe_services.recorder.process import run_recorder
from passafe_services.loop.router_endpoint import RouterEndpoint
metadata = run_metadata(scenario_json=sys.argv[3], versions={}, driver="live")
try:
    run_recorder(RouterEndpoint(port=int(sys.argv[1])), Path(sys.argv[2]), metadata, epoch=1, lifeline=True)
except LogFileError as error:
    sys.exit(str(error))
"""

pytestmark = pytest.mark.live

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start a Python process and wait until it is ready; none outlives the test."""
    started: list[subprocess.Popen[str]] = []

    def start_ready(name: str, program: str, *arguments: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, "-c", program, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        started.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == f"{ready_line(name)}\n", process.communicate(timeout=PATIENCE_S)
        return process

    yield start_ready
    for process in reversed(started):
        process.kill()
        process.communicate(timeout=PATIENCE_S)


@pytest.fixture
def endpoint(start: Start) -> RouterEndpoint:
    """Return the port of a router."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    start("router", ROUTER, str(port))
    return RouterEndpoint(port=port)


def start_recorder(start: Start, endpoint: RouterEndpoint, path: Path) -> "subprocess.Popen[str]":
    """Start a recorder of the paper's scenario that writes to ``path``."""
    scenario_json = load_scenario("notomista-cai-2020").model_dump_json()
    return start("recorder", RECORDER, str(endpoint.port), str(path), scenario_json)


def health_with(reader: TopicReader, received: int) -> TopicHealth:
    """Return the recorder's health of the events once it has received a number of them."""
    give_up_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < give_up_s:
        for data in reader.drain():
            header, body = decode(HEALTH, data)
            assert header.source == "recorder"
            assert isinstance(body, Health)
            for topic in body.topics:
                if topic.topic == EVENT.name and topic.received >= received:
                    return topic
        time.sleep(0.01)  # readers are polled
    raise TimeoutError


def test_every_message_of_the_bus_is_in_the_log(tmp_path: Path, start: Start, endpoint: RouterEndpoint) -> None:
    path = tmp_path / "run.mcap"
    recorder = start_recorder(start, endpoint, path)
    with open_bus(endpoint) as bus:
        health = bus.reader(HEALTH)
        outlet = Outlet(bus, "plant", 7)
        for k in range(MESSAGES):
            outlet.publish(EVENT, Event("info", f"number {k}"), scheduled_ns=0, started_ns=0)
        assert health_with(health, MESSAGES) == TopicHealth("event", received=MESSAGES, gaps=0, refused=0)
        outlet.publish(EVENT, Event("info", "the last"), scheduled_ns=0, started_ns=0)
        recorder.terminate()
        output, errors = recorder.communicate(timeout=PATIENCE_S)
    assert (recorder.returncode, output, errors) == (0, "", "")
    log = RunLog.read(path)
    assert log.finished
    texts = [message.body.text for message in log.of(Event)]
    assert texts == [f"number {k}" for k in range(MESSAGES)] + ["the last"]
    assert log.counts["event"] == TopicCount(received=MESSAGES + 1, sessions=1)
    assert log.of(Health)[0].header.source == "recorder"


def test_a_process_that_ends_waits_for_a_recorder_behind(
    tmp_path: Path, start: Start, endpoint: RouterEndpoint
) -> None:
    """The caches of a process end with it, and a loaded machine may not have let the recorder run for a second."""
    path = tmp_path / "run.mcap"
    recorder = start_recorder(start, endpoint, path)
    go_on = Timer(1.5, os.kill, (recorder.pid, signal.SIGCONT))
    with open_bus(endpoint) as bus:
        health, outlet, receipts = bus.reader(HEALTH), Outlet(bus, "plant", 7), Receipts(bus)
        for k in range(MESSAGES):
            if k == 500:
                health_with(health, 1)  # the recorder knows the publisher
                os.kill(recorder.pid, signal.SIGSTOP)
                go_on.start()
            outlet.publish(EVENT, Event("info", f"number {k}"), scheduled_ns=0, started_ns=0)
            time.sleep(2e-4)
        missing = receipts.wait_for(outlet)
    recorder.terminate()
    output, errors = recorder.communicate(timeout=PATIENCE_S)
    log = RunLog.read(path)

    assert (missing, recorder.returncode, output, errors) == (0, 0, "", "")
    assert log.counts["event"].received == MESSAGES + sum(event.header.source == "recorder" for event in log.of(Event))
    assert log.counts["event"].gaps == 0
