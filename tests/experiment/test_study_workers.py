"""Worker processes, here and in a cluster: the same results as in this process, to the last bit."""

from collections.abc import Iterator
from contextlib import closing
from functools import partial
from typing import Any

import pytest
from passafe_services.tools.experiment.cells import Run, RunKey
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.experiment.study_job import StudyJob, chunk_size
from passafe_services.tools.runs.dask_workers import dask_workers
from passafe_services.tools.runs.errors import SchedulerError
from passafe_services.tools.runs.sweep import sweep
from passafe_services.tools.runs.worker_processes import WorkerProcesses
from passafe_services.tools.runs.workers import Workers
from studies import study

distributed: Any = pytest.importorskip("distributed")


def swept() -> Study:
    bad = {"links.plant-to-filter.loss": 0.2, "links.filter-to-plant.jitter_s": 0.02}
    jitter = {"name": "j", "kind": "log-uniform", "key": "links.plant-to-filter.jitter_s", "low": 0.001, "high": 0.1}
    hold = {"name": "hold_s", "kind": "bisect", "key": "plant.hold_s", "low": 0.0, "high": 0.2, "steps": 1, "scan": 1}
    return study(
        overrides=bad,
        start="random",
        tracking=True,
        variants={"both": {}, "off": {"filter.mode": "off"}},
        axes=[jitter, hold],
        seeds={"count": 2},
        criteria={"served": {"metric": "fail_safe_s", "at_least": 0.01}},
    )


def metrics_by(workers: Workers[Run, RunResult], one: Study) -> dict[RunKey, Metrics | None]:
    size = partial(chunk_size, workers=workers.count)
    found = [result for chunk in sweep(Plan(one.experiment), workers, size) for result in chunk]
    assert not [result.error for result in found if result.error]
    return {result.run.key: result.metrics for result in found}


@pytest.fixture(scope="module")
def alone() -> dict[RunKey, Metrics | None]:
    """Return what this process gives."""
    one = swept()
    plan, runner = Plan(one.experiment), StudyRunner(one)
    waiting = list(plan.first())
    while waiting:
        waiting += plan.after(runner.result(waiting.pop(0)))
    return {key: result.metrics for key, result in plan.results.items()}


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """Give a real cluster of two processes on loopback, on ports that the system chose."""
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=2,
        processes=True,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        protocol="tcp",
    ) as running:
        yield running.scheduler_address


@pytest.mark.live
@pytest.mark.parametrize("count", [1, 2])
def test_worker_processes_give_what_this_process_gives(alone: dict[RunKey, Metrics | None], count: int) -> None:
    with closing(WorkerProcesses(StudyJob.of(swept()), count)) as workers:
        assert workers.count == count
        assert metrics_by(workers, swept()) == alone
    assert len(alone) >= 2 * 3 * 2


@pytest.mark.live
def test_a_dask_cluster_gives_what_this_process_gives(alone: dict[RunKey, Metrics | None], cluster: str) -> None:
    with dask_workers(StudyJob.of(swept()), cluster) as workers:
        assert workers.count == 2
        assert metrics_by(workers, swept()) == alone


@pytest.mark.live
def test_no_scheduler_and_no_workers_are_reported() -> None:
    job = StudyJob.of(swept())
    with (
        pytest.raises(SchedulerError, match="allowed the address of a running Dask scheduler"),
        dask_workers(job, "nowhere"),
    ):
        pass
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0") as idle,
        pytest.raises(SchedulerError, match="no workers"),
        dask_workers(job, idle.scheduler_address),
    ):
        pass


@pytest.mark.live
def test_workers_of_another_version_are_refused(cluster: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("passafe_services.scenarios.info._versions", lambda: {"passafe": "9"})

    with (
        pytest.raises(SchedulerError, match="allowed workers with"),
        dask_workers(StudyJob.of(swept()), cluster),
    ):
        pass
