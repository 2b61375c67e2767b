"""Priority and garbage collector."""

import gc
import subprocess
import sys

from services.runtime.realtime import quiet_collector

ASK = """
import os
from services.runtime.realtime import request_realtime
reason = request_realtime({priority})
granted = os.sched_getscheduler(0) == os.SCHED_FIFO
print(granted, os.sched_getparam(0).sched_priority, reason)
"""


def asked(priority: int) -> str:
    code = ASK.format(priority=priority)
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=20)
    return ran.stdout.strip()


def test_real_time_priority_is_granted_or_the_refusal_has_a_reason() -> None:
    told = asked(7)
    assert told == "True 7 None" or told.startswith("False 0 no real-time priority (")


def test_a_priority_that_the_system_does_not_know_is_a_refusal_and_no_error() -> None:
    assert asked(5_000).startswith("False 0 no real-time priority (")


def test_the_collector_runs_when_asked_and_only_then() -> None:
    class Ring:
        count = 0

        def __init__(self) -> None:
            self.me = self

        def __del__(self) -> None:
            Ring.count += 1

    with quiet_collector() as collect:
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 0
        for _ in range(20_000):
            Ring()
        assert Ring.count == 0
        collect()
        assert Ring.count == 20_000
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
