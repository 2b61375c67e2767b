"""Requests to stop: signals and the lifeline."""

import os
import signal
import subprocess
import sys
import threading

import pytest
from passafe_services.loop.stop import StopReason, stop_requests


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_signal_requests_a_stop_and_ends_the_wait(signum: int) -> None:
    before = signal.getsignal(signum)
    with stop_requests(lifeline=False) as stop:
        assert stop.reason is None
        assert not stop.wait(0.0)
        threading.Timer(0.01, os.kill, (os.getpid(), signum)).start()
        assert stop.wait(20.0)
        assert stop.reason is StopReason.SIGNAL
        assert signal.getsignal(signum) == signal.SIG_DFL  # a second one ends the process
    assert signal.getsignal(signum) == before


def test_first_reason_is_kept_and_a_second_wait_returns_at_once() -> None:
    with stop_requests(lifeline=False) as stop:
        stop.request(StopReason.FINISHED)
        stop.request(StopReason.SIGNAL)
        assert stop.reason is StopReason.FINISHED
        assert stop.wait()
        assert stop.wait()


LIFELINE = """
import sys
import passafe_services.loop.stop as stop_module
stop_module.LIFELINE_GRACE_S = 0.2
with stop_module.stop_requests(lifeline=True) as stop:
    print("ready", flush=True)
    stop.wait(20.0)
    print(stop.reason.name, flush=True)
    while {hangs}:
        pass
"""


def run_with_lifeline(*, hangs: bool) -> tuple[str, int]:
    code = LIFELINE.format(hangs=hangs)
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"
        process.stdin.write("what is written does not matter\n")
        process.stdin.flush()
        assert process.poll() is None
        process.stdin.close()
        output = process.stdout.readline().strip()
        return output, process.wait(20.0)


def test_end_of_the_lifeline_requests_a_stop() -> None:
    assert run_with_lifeline(hangs=False) == ("LIFELINE", 0)


def test_a_process_that_does_not_end_with_its_lifeline_is_killed() -> None:
    assert run_with_lifeline(hangs=True) == ("LIFELINE", -signal.SIGKILL)
