"""Worker processes, here and in a cluster: the same results as in this process, to the last bit."""

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from passafe_services.tools.experiment.errors import SchedulerError, WorkerLostError
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.experiment.runs import RunKey
from passafe_services.tools.experiment.worker_pool import WorkerPool, dask_cluster, local_processes, results
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
        criteria={"served": {"figure": "fail_safe_s", "at_least": 0.01}},
    )


def figures_by(crew: WorkerPool, one: Study) -> dict[RunKey, Metrics | None]:
    found = list(results(Plan(one.experiment), one, crew, lambda: False))
    assert not [result.error for result in found if result.error]
    return {result.run.key: result.figures for result in found}


@pytest.fixture(scope="module")
def alone() -> dict[RunKey, Metrics | None]:
    with local_processes(1) as crew:
        return figures_by(crew, swept())


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """A real cluster of two processes on loopback, on ports that the system chose."""
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
def test_two_processes_give_what_one_gives(alone: dict[RunKey, Metrics | None]) -> None:
    with local_processes(2) as crew:
        assert crew.workers == 2
        assert figures_by(crew, swept()) == alone
    assert len(alone) >= 2 * 3 * 2


@pytest.mark.live
def test_a_dask_cluster_gives_what_one_process_gives(alone: dict[RunKey, Metrics | None], cluster: str) -> None:
    with dask_cluster(cluster) as crew:
        assert crew.workers == 2
        assert figures_by(crew, swept()) == alone


@pytest.mark.live
def test_no_scheduler_and_no_workers_are_told() -> None:
    with (
        pytest.raises(SchedulerError, match="allowed the address of a running Dask scheduler"),
        dask_cluster("nowhere"),
    ):
        pass
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0") as idle,
        pytest.raises(SchedulerError, match="no workers"),
        dask_cluster(idle.scheduler_address),
    ):
        pass


@pytest.mark.live
def test_workers_of_another_version_are_refused(cluster: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("passafe_services.scenarios.info._versions", lambda: {"passafe": "9"})

    with pytest.raises(SchedulerError, match="allowed workers with"), dask_cluster(cluster):
        pass


def test_who_wants_to_stop_gets_what_is_done_and_nothing_more() -> None:
    one = swept()
    plan = Plan(one.experiment)
    with local_processes(1) as crew:
        taken = list(results(plan, one, crew, lambda: len(plan.results) >= 3))

    assert len(taken) == 3
    assert len(plan.results) == 3


@pytest.mark.live
def test_who_wants_to_stop_waits_for_what_is_in_work() -> None:
    one = swept()
    plan = Plan(one.experiment)
    with local_processes(2) as crew:
        taken = list(results(plan, one, crew, lambda: bool(plan.results)))
    whole = StudyRunner(one)

    assert 1 <= len(taken) <= crew.workers * crew.ahead * crew.portion
    assert [whole.result(result.run).figures for result in taken] == [result.figures for result in taken]


@pytest.mark.live
def test_a_worker_that_is_killed_is_told() -> None:
    one = swept()
    with local_processes(2) as crew:
        os.kill(crew.executor.submit(os.getpid).result(), signal.SIGKILL)
        with pytest.raises(WorkerLostError, match="goes on"):
            list(results(Plan(one.experiment), one, crew, lambda: False))
