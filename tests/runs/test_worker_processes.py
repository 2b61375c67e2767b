"""Worker processes: their results, and that a dead one is never waited for."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest
from passafe_services.tools.runs.errors import WorkerLostError
from passafe_services.tools.runs.sweep import FixedPlan, sweep
from passafe_services.tools.runs.worker_processes import WorkerProcesses
from sleep_job import SleepJob, Task, TwoArgumentsError

SOON_S = 5.0
"""On an idle machine it is milliseconds."""


def one_by_one(_: int) -> int:
    return 1


def test_every_task_is_done_once_by_several_processes() -> None:
    tasks = [Task(sleep_s=0.05, size=size) for size in range(40)]

    with closing(WorkerProcesses(SleepJob(), 2)) as workers:
        found = [result for chunk in sweep(FixedPlan(tasks), workers, lambda _: 2) for result in chunk]

    assert sorted(len(sent) for _, sent in found) == list(range(40))
    assert len({pid for pid, _ in found}) == 2


def test_tasks_that_a_result_asks_for_are_done_too() -> None:
    class Doubling:
        def first(self) -> list[Task]:
            return [Task(size=1)]

        def after(self, result: tuple[int, bytes]) -> list[Task]:
            return [Task(size=2 * len(result[1]))] * 2 if len(result[1]) < 4 else []

    with closing(WorkerProcesses(SleepJob(), 2)) as workers:
        found = [len(sent) for chunk in sweep(Doubling(), workers, one_by_one) for _, sent in chunk]

    assert sorted(found) == [1, 2, 2, 4, 4, 4, 4]


def test_an_error_of_a_task_is_raised_as_it_was() -> None:
    with (
        closing(WorkerProcesses(SleepJob(), 1)) as workers,
        pytest.raises(TwoArgumentsError, match="one and two") as caught,
    ):
        list(sweep(FixedPlan([Task(size=-1)]), workers, one_by_one))

    assert caught.value.second == "two"
    assert "in done" in caught.value.__notes__[0]


def test_a_worker_that_is_killed_at_work_ends_the_sweep_at_once() -> None:
    begun_s = time.monotonic()

    with closing(WorkerProcesses(SleepJob(), 2)) as workers, pytest.raises(WorkerLostError, match="resumes"):
        list(sweep(FixedPlan([Task(sleep_s=60.0), Task(size=-2)]), workers, one_by_one))

    assert time.monotonic() - begun_s < SOON_S


def test_a_worker_killed_while_it_sends_is_lost_at_once() -> None:
    """The other one would wait for ever for a lock of a common queue, and the parent for the rest of the message."""
    with closing(WorkerProcesses(SleepJob(), 2)) as workers:
        for _ in workers.processes:
            workers.submit([Task(size=50_000_000)])
        time.sleep(1.0)  # nobody reads: more than a pipe holds
        os.kill(workers.processes[0].pid or 0, signal.SIGKILL)
        begun_s = time.monotonic()
        with pytest.raises(WorkerLostError):
            list(sweep(FixedPlan([]), workers, one_by_one))
    assert time.monotonic() - begun_s < SOON_S


@pytest.mark.parametrize("after_s", [0.0, 1.0])
def test_a_worker_that_dies_idle_or_while_it_starts_is_lost(after_s: float) -> None:
    with closing(WorkerProcesses(SleepJob(), 2)) as workers:
        time.sleep(after_s)
        os.kill(workers.processes[0].pid or 0, signal.SIGKILL)
        with pytest.raises(WorkerLostError):
            list(sweep(FixedPlan([Task(sleep_s=0.1)] * 1000), workers, one_by_one))


def test_a_request_to_stop_ends_the_sweep_at_once() -> None:
    stop = threading.Event()
    threading.Timer(1.0, stop.set).start()
    begun_s = time.monotonic()
    with closing(WorkerProcesses(SleepJob(), 2)) as workers:
        found = list(sweep(FixedPlan([Task(sleep_s=60.0)] * 4), workers, one_by_one, stop.is_set))
        processes = workers.processes

    assert found == []
    assert time.monotonic() - begun_s < 1.0 + SOON_S
    assert not any(process.is_alive() for process in processes)


def test_a_worker_lost_after_a_request_to_stop_is_no_error() -> None:
    asked = iter([False])
    with closing(WorkerProcesses(SleepJob(), 1)) as workers:
        assert list(sweep(FixedPlan([Task(size=-2)]), workers, one_by_one, lambda: next(asked, True))) == []


def test_workers_end_with_a_parent_that_is_killed() -> None:
    program = (
        "import time\n"
        "from contextlib import closing\n"
        "from passafe_services.tools.runs.worker_processes import WorkerProcesses\n"
        "from sleep_job import SleepJob, Task\n"
        "with closing(WorkerProcesses(SleepJob(), 2)) as workers:\n"
        "    workers.submit([Task()])\n"
        "    workers.completed(60.0)\n"
        "    workers.submit([Task(sleep_s=100.0)])\n"
        "    print(*(process.pid for process in workers.processes), flush=True)\n"
        "    time.sleep(100.0)\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, env=environment
    ) as parent:
        assert parent.stdout is not None
        pids = [int(pid) for pid in parent.stdout.readline().split()]
        assert [is_running(pid) for pid in pids] == [True, True]
        parent.kill()

    deadline_s = time.monotonic() + SOON_S
    while any(is_running(pid) for pid in pids) and time.monotonic() < deadline_s:
        time.sleep(0.02)
    assert [is_running(pid) for pid in pids] == [False, False]


def is_running(pid: int) -> bool:
    """Return whether a process runs; one that nobody waited for does not."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"
