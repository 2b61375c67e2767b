"""Jobs through the server: reviews, comparisons and re-runs in processes of their own."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsed_archive import BrowsedArchive, browse_folder
from closed_form_log import circle_messages, write_log
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of

REVIEW = {"kind": "review", "log": "run.mcap"}
LONG_S = 20.0
"""Length of a run about which a job is at work for seconds, so that it can be met there on a busy machine."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a runs folder with two simulated runs, a circle, and files that are no logs."""
    folder = tmp_path_factory.mktemp("runs")
    _simulate(folder / "run.mcap", 0.3)
    _simulate(folder / "long.mcap", LONG_S)
    write_log(folder / "circle.mcap", circle_messages(300))
    (folder / "words.mcap").write_text("no log")
    return folder


def _simulate(path: Path, duration_s: float) -> None:
    scenario = load_scenario("notomista-cai-2020", {"duration_s": duration_s})
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(path, metadata) as writer:
        loop = lockstep_loop(scenario, LockstepLog(writer))
        loop.run(steps_of(scenario))
        loop.finish()


@pytest.fixture(scope="module")
def page(runs: Path) -> Iterator[BrowsedArchive]:
    with browse_folder(runs) as served:
        yield served


def test_a_review_becomes_a_report(page: BrowsedArchive) -> None:
    job = page.finished(REVIEW)
    assert (job["state"], job["share"], job["result"]) == ("done", 1.0, f"/api/jobs/{job['job']}/result")
    report = page.get(job["result"]).json()
    assert "Every required property holds" in report["markup"]
    assert [run["label"] for run in report["data"]["runs"]] == ["run"]
    again = page.post(REVIEW).json()
    assert (again["job"], again["state"]) == (job["job"], "done")


def test_the_list_has_the_verdicts_of_reviewed_logs(page: BrowsedArchive, runs: Path) -> None:
    _simulate(runs / "new.mcap", 0.3)
    assert page.get("/api/logs/new.mcap").json()["verdict"] == ""
    assert page.finished({"kind": "review", "log": "new.mcap"})["state"] == "done"
    listed = {entry["name"]: entry["verdict"] for entry in page.get("/api/logs").json()["logs"]}
    assert (listed["new.mcap"], listed["long.mcap"]) == ("holds", "")
    os.utime(runs / "new.mcap", (1, 1))
    assert page.get("/api/logs/new.mcap").json()["verdict"] == ""
    (runs / "new.mcap").unlink()


def test_a_changed_log_is_reviewed_again(page: BrowsedArchive, runs: Path) -> None:
    first = page.finished({"kind": "review", "log": "words.mcap"})
    assert first["state"] == "failed"
    assert "words.mcap" in first["text"]
    assert page.get(f"/api/jobs/{first['job']}/result").status_code == 409
    os.utime(runs / "words.mcap", (1, 1))
    assert page.post({"kind": "review", "log": "words.mcap"}).json()["job"] != first["job"]


def test_a_what_if_writes_a_log_and_compares(page: BrowsedArchive, runs: Path) -> None:
    changes = {"links.plant-to-filter.delay_s": 0.05, "filter.mode": "safe"}
    before = (runs / "run.mcap").read_bytes()
    job = page.finished({"kind": "what-if", "log": "run.mcap", "changes": changes})
    assert (job["state"], job["log"]) == ("done", "run-what-if-1.mcap"), job["text"]
    report = page.get(job["result"]).json()
    assert "changed: filter.mode both -&gt; safe; links.plant-to-filter.delay_s 0 -&gt; 0.05" in report["markup"]
    assert "the person does not react" in report["markup"]
    assert [run["label"] for run in report["data"]["runs"]] == ["log", "what if"]
    entry = page.get("/api/logs/run-what-if-1.mcap").json()
    assert (entry["source"], entry["state"]) == ("run.mcap", "finished")
    assert (runs / "run.mcap").read_bytes() == before


def test_a_change_that_cannot_be_made_is_named(page: BrowsedArchive, runs: Path) -> None:
    job = page.finished({"kind": "what-if", "log": "run.mcap", "changes": {"filter.k_j": 1}})
    assert job["state"] == "failed"
    assert "k_j" in job["text"]
    assert not [path for path in runs.iterdir() if path.stat().st_size == 0]


@pytest.mark.parametrize(
    "request_",
    [
        {},
        {"kind": "guess"},
        {"kind": "review"},
        {"kind": "review", "log": ""},
        {"kind": "review", "log": "run.mcap", "more": 1},
        {"kind": "compare", "logs": ["run.mcap"]},
        {"kind": "what-if", "log": "run.mcap", "changes": {"duration_s": 1e9}},
        {"kind": "what-if", "log": "run.mcap", "changes": {"operator.source": "x"}},
        {"kind": "what-if", "log": "run.mcap", "changes": {"links.plant-to-filter.trace": "/dev/zero"}},
        {"kind": "what-if", "log": "run.mcap", "changes": {"filter.k_i": {"a": 1}}},
        {"kind": "what-if", "log": "run.mcap", "changes": {f"filter.a{k}": 1 for k in range(40)}},
        {"kind": "cell-run", "experiment": "x", "cell": -1, "seed": 0},
    ],
)
def test_a_request_of_another_form_is_refused(page: BrowsedArchive, request_: Any) -> None:  # noqa: ANN401 - JSON
    assert page.post(request_).status_code == 422


def test_unknown_names_are_refused(page: BrowsedArchive) -> None:
    assert page.post({"kind": "review", "log": "../run.mcap"}).status_code == 404
    assert page.post({"kind": "compare", "logs": ["run.mcap", "gone.mcap"]}).status_code == 404
    assert page.get("/api/jobs/999").status_code == 404
    assert page.delete("999").status_code == 404
    assert page.post(REVIEW, Origin="http://evil.example").status_code == 403


def test_jobs_are_bounded_and_leave_nothing_when_cancelled(page: BrowsedArchive, runs: Path) -> None:
    request = {"kind": "what-if", "log": "long.mcap", "links": "drawn"}
    before = set(runs.iterdir())
    answers = [page.post(request) for _ in range(9)]
    assert [answer.status_code for answer in answers] == [202] * 8 + [429]
    first, *others = [answer.json()["job"] for answer in answers[:8]]
    for job in others:
        assert page.delete(job).json()["state"] == "cancelled"
    page.until(first, lambda _: set(runs.iterdir()) > before)
    assert page.delete(first).json()["state"] == "cancelled"
    assert set(runs.iterdir()) == before


def test_a_killed_process_is_named(page: BrowsedArchive) -> None:
    job = page.post({"kind": "review", "log": "long.mcap"}).json()["job"]
    page.until(job, lambda found: found["text"] not in ("waiting for its turn", "starting"))
    [child] = children_of(os.getpid())
    os.kill(child, signal.SIGKILL)
    over = page.over(job)
    assert over["state"] == "failed"
    assert "signal 9" in over["text"]


def children_of(pid: int) -> list[int]:
    """Return the processes of jobs that a process has started."""
    children = [
        int(child) for path in Path(f"/proc/{pid}/task").glob("*/children") for child in path.read_text().split()
    ]
    return [child for child in children if b"job_process" in Path(f"/proc/{child}/cmdline").read_bytes()]
