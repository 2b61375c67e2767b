"""Runs one process of passafe with a wall clock that is wrong: ``python skewed_process.py OFFSET_S PROCESS …``.

Linux has namespaces for the monotonic clock, not for the wall clock; libfaketime fails at Python's sleep.
"""

import runpy
import sys
import time

OFFSET_S = float(sys.argv.pop(1))
OFFSET_NS = round(OFFSET_S * 1e9)
_true_time, _true_time_ns = time.time, time.time_ns


def _skewed_time() -> float:
    return _true_time() + OFFSET_S


def _skewed_time_ns() -> int:
    return _true_time_ns() + OFFSET_NS


time.time, time.time_ns = _skewed_time, _skewed_time_ns

if __name__ == "__main__":
    runpy.run_module("passafe_services.cli.run", run_name="__main__", alter_sys=True)
