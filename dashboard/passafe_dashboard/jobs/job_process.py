"""Run one job in a process of its own, behind everything else: ``python -m`` starts it, with its niceness."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from threading import Thread

FIRST_TO_KILL = 1000
"""Adjustment by which the system kills this process before any other when memory runs out."""


def step_back(niceness: int) -> None:
    """Give way to every other process: with the processors, and where memory runs out."""
    own = os.getpriority(os.PRIO_PROCESS, 0)  # a page beside a robot is before others, which its jobs are not to be
    os.setpriority(os.PRIO_PROCESS, 0, max(niceness, own + niceness))
    for file, text in (("autogroup", str(niceness)), ("oom_score_adj", str(FIRST_TO_KILL))):
        with suppress(OSError):  # not supported here
            Path(f"/proc/self/{file}").write_text(text, encoding="ascii")


def main() -> None:
    """Read the order, do the work, report on standard output."""
    step_back(int(sys.argv[1]))
    line = sys.stdin.buffer.readline()
    Thread(target=_end_with_the_server, name="lifeline", daemon=True).start()
    from passafe.errors import PassafeError  # noqa: PLC0415 - what takes a second to import comes after stepping back
    from passafe_dashboard.jobs.job_order import JobOrder, JobReport  # noqa: PLC0415 - likewise
    from passafe_dashboard.jobs.job_work import do  # noqa: PLC0415 - likewise

    def report(about: JobReport) -> None:
        sys.stdout.write(about.model_dump_json() + "\n")
        sys.stdout.flush()

    order = JobOrder.model_validate_json(line)
    try:
        report(do(order, report))
    except PassafeError as error:
        report(JobReport(event="refused", text=str(error)))
    except MemoryError:
        report(JobReport(event="refused", text="out of memory"))
    except OSError as error:
        report(JobReport(event="refused", text=f"{error.filename or 'file'}: {error.strerror or error}"))


def _end_with_the_server() -> None:
    sys.stdin.buffer.read()
    os._exit(1)


if __name__ == "__main__":
    main()
