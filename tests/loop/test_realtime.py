"""Priority, processors and garbage collector."""

import gc
import subprocess
import sys

from passafe_services.loop.realtime import LOOPS, paused_garbage_collection

ASK = """
import os
from passafe_services.loop.realtime import request_realtime
reason = request_realtime({priority})
granted = os.sched_getscheduler(0) == os.SCHED_FIFO
print(granted, os.sched_getparam(0).sched_priority, reason)
"""


def asked(priority: int) -> str:
    return asked_and("", priority)


def asked_and(more: str, priority: int) -> str:
    code = ASK.format(priority=priority) + more
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=20)
    return ran.stdout.strip()


def test_realtime_priority_is_granted_or_refused_with_a_reason() -> None:
    reported = asked(7)
    assert reported == "True 7 None" or reported.startswith("False 0 no real-time priority (")


def test_unknown_priority_is_a_refusal_not_an_error() -> None:
    assert asked(5_000).startswith("False 0 no real-time priority (")


def test_setup_priority_is_below_every_loop() -> None:
    lowered = (
        "\nfrom passafe_services.loop.realtime import lower_priority\nlower_priority()"
        "\nprint(os.sched_getparam(0).sched_priority)"
    )
    granted, priority, *_, after = asked_and(lowered, 7).split()
    assert (granted, priority, after) in {("True", "7", "1"), ("False", "0", "0")}


HAVE = "import os; print(*sorted(os.sched_getaffinity(0)))"
OWN = """
import os
from passafe_services.loop.realtime import pin_to_processor
os.sched_setaffinity(0, {processors})
pin_to_processor({name!r})
print(*sorted(os.sched_getaffinity(0)))
"""


def processors_of(code: str) -> list[int]:
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=20)
    return [int(processor) for processor in ran.stdout.split()]


def test_loops_are_pinned_to_different_processors() -> None:
    there = processors_of(HAVE)
    for processors in ({there[0]}, {*there[:2]}, {*there[:3]}):
        kept = [processors_of(OWN.format(processors=processors, name=name)) for name in LOOPS]
        assert all(len(own) == 1 for own in kept)
        assert {own[0] for own in kept} == processors
        assert kept[0] == [max(processors)]


def test_a_process_without_a_loop_stays_where_it_may_be() -> None:
    there = processors_of(HAVE)
    assert processors_of(OWN.format(processors=set(there), name="recorder")) == there


def test_garbage_collection_runs_only_on_request() -> None:
    class Ring:
        count = 0

        def __init__(self) -> None:
            self.me = self

        def __del__(self) -> None:
            Ring.count += 1

    with paused_garbage_collection() as collect:
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 0
        for _ in range(20_000):
            Ring()
        assert Ring.count == 0
        collect()
        assert Ring.count == 20_000
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
