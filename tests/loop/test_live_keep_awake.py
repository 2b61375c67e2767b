"""Processes that keep processors from halting."""

import os
import sys
import time
from pathlib import Path

import pytest
from passafe_services.loop.keep_awake import awake_specs
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.supervisor import supervise

pytestmark = [pytest.mark.live, pytest.mark.skipif(sys.platform != "linux", reason="SCHED_IDLE is Linux's")]

PATIENCE_S = 20.0


def children() -> list[int]:
    me = os.getpid()
    return [int(pid) for pid in Path(f"/proc/{me}/task/{me}/children").read_text().split()]


def test_one_process_for_each_processor() -> None:
    specs = awake_specs()
    assert [spec.name for spec in specs] == [f"awake-{cpu}" for cpu in sorted(os.sched_getaffinity(0))]


def test_it_holds_its_processor_at_idle_priority_until_stopped() -> None:
    cpu = min(os.sched_getaffinity(0))
    before = set(children())

    def look() -> None:
        (pid,) = set(children()) - before
        assert os.sched_getaffinity(pid) == {cpu}
        end = time.monotonic() + PATIENCE_S
        while os.sched_getscheduler(pid) != os.SCHED_IDLE:
            assert time.monotonic() < end
            time.sleep(0.01)

    outcome = supervise(awake_specs()[:1], duration_s=0.0, on_ready=look)
    assert outcome.cause is ExitCause.DURATION
    assert outcome.clean, outcome
