"""Sweeps that are started in the page: one at a time, ended at once, resumed, refused in words."""

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
from browsed_archive import BrowsedArchive, browse_folder
from passafe_services.tools.experiment.load import shipped_experiments
from passafe_services.tools.experiment.sweep_state import state_writer
from small_sweep import EXPERIMENT_TOML, small_study, write_results

SMALL = {"kind": "sweep", "source": "file", "experiment": "mine/small.toml"}
LONG = {"kind": "sweep", "source": "file", "experiment": "long.toml"}


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    """Return a runs folder with experiments of which one takes a minute, a scenario, and what is neither."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "small.toml").write_text(EXPERIMENT_TOML)
    (tmp_path / "long.toml").write_text(
        EXPERIMENT_TOML.replace('"small"', '"long"').replace("count = 2", "count = 400").replace("0.1", "2.0")
    )
    (tmp_path / "wrong.toml").write_text(EXPERIMENT_TOML.replace("h_min", "h_mim").replace("count = 2", "count = 0"))
    (tmp_path / "scenario.toml").write_text('schema_version = 1\nname = "x"\n')
    (tmp_path / "words.toml").write_text("no TOML")
    return tmp_path


@pytest.fixture
def page(runs: Path) -> Iterator[BrowsedArchive]:
    with browse_folder(runs) as served:
        yield served


def known(page: BrowsedArchive, name: str) -> Any:  # noqa: ANN401 - JSON
    return page.get(f"/api/experiments/{name}").json()["entry"]


def test_experiments_that_can_be_started_are_listed(page: BrowsedArchive) -> None:
    found = page.get("/api/experiment-offers").json()
    offers = {offer["experiment"]: offer for offer in found["offers"]}
    assert list(offers) == [*shipped_experiments(), "long.toml", "mine/small.toml", "wrong.toml"]
    assert (offers["mine/small.toml"]["cells"], offers["mine/small.toml"]["most_runs"]) == (4, 8)
    assert "h_mim" in offers["wrong.toml"]["trouble"]
    assert all(offer["most_runs"] <= found["most_runs"] for offer in offers.values())


def test_an_experiment_is_run_to_its_report(page: BrowsedArchive, runs: Path) -> None:
    job = page.finished(SMALL | {"seeds": 1})
    assert (job["state"], job["text"], job["experiment"]) == ("done", "done", "small"), job
    entry = known(page, "small")
    assert (entry["stage"], entry["runs"], entry["job"]["state"]) == ("finished", 4, "done")
    for file in ("runs.csv", "cells.parquet", "summary.json", "report.html"):
        assert (runs / "small" / file).is_file()
    cells = page.get("/api/experiments/small").json()["cells"]
    logs = [probe["log"] for cell in cells for probe in cell["probes"]]
    assert page.get(f"/api/logs/{logs[0]}").json()["state"] == "finished"
    assert page.finished(SMALL | {"seeds": 1})["experiment"] == "small-2"


def test_a_sweep_ends_at_once_and_resumes(page: BrowsedArchive) -> None:
    job = page.post(LONG).json()["job"]
    page.until(job, lambda found: known(page, "long")["runs"] > 0 if found.get("experiment") else False)
    refused = page.post(SMALL)
    assert (refused.status_code, "experiment long is running" in refused.text) == (429, True)
    [sweeps] = [
        child for child in psutil.Process().children() if any("job_process" in word for word in child.cmdline())
    ]
    workers = sweeps.children(recursive=True)
    assert workers
    assert page.delete(job).json()["state"] == "cancelled"
    _, left = psutil.wait_procs([sweeps, *workers], timeout=5)
    assert not left
    stopped = known(page, "long")
    assert (stopped["stage"], stopped["job"]["state"]) == ("interrupted", "cancelled")
    again = page.post({"kind": "sweep", "source": "folder", "experiment": "long"}).json()["job"]
    page.until(again, lambda _: known(page, "long")["runs"] > stopped["runs"])
    assert known(page, "long")["most_runs"] == 1600
    assert page.delete(again).json()["state"] == "cancelled"


def test_a_killed_sweep_says_so_beside_its_map(page: BrowsedArchive) -> None:
    job = page.post(LONG).json()["job"]
    page.until(job, lambda found: bool(found.get("experiment")))
    state = json.loads((Path(page.get("/api/logs").json()["folder"]) / "long" / "sweep.json").read_text())
    os.kill(state["pid"], signal.SIGKILL)
    assert page.over(job)["state"] == "failed"
    assert "signal 9" in known(page, "long")["job"]["text"]


def test_what_is_wrong_with_a_file_is_named(page: BrowsedArchive) -> None:
    job = page.finished(SMALL | {"experiment": "wrong.toml"})
    assert job["state"] == "failed"
    assert "h_mim" in job["text"]
    assert "seeds.count" in job["text"]
    assert page.get("/api/experiments").json()["experiments"] == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"count = 2": "count = 2000"}, "got 8000 runs, allowed up to 5000 in the page"),
        ({"0.1": "600.0"}, "got runs of 600000 ticks, allowed up to 120000 in the page"),
    ],
)
def test_what_is_too_large_is_refused(page: BrowsedArchive, runs: Path, change: dict[str, str], words: str) -> None:
    [(old, new)] = change.items()
    (runs / "large.toml").write_text(EXPERIMENT_TOML.replace(old, new))
    job = page.finished(SMALL | {"experiment": "large.toml"})
    assert (job["state"], words in job["text"]) == ("failed", True), job["text"]


@pytest.mark.parametrize(
    ("source", "name"),
    [
        ("shipped", "delai"),
        ("shipped", "mine/small.toml"),
        ("file", "../small.toml"),
        ("file", "mine/none.toml"),
        ("file", "delay"),
        ("folder", "mine"),
        ("folder", ".."),
    ],
)
def test_a_name_of_nothing_is_refused(page: BrowsedArchive, source: str, name: str) -> None:
    assert page.post({"kind": "sweep", "source": source, "experiment": name}).status_code == 404


def test_a_page_of_another_site_starts_nothing(page: BrowsedArchive) -> None:
    assert page.post(SMALL, Origin="http://evil.example").status_code == 403
    assert page.get("/api/jobs").json()["jobs"] == []


def test_a_folder_that_another_process_writes_is_left_alone(page: BrowsedArchive, runs: Path) -> None:
    study = small_study()
    state_writer(write_results(runs / "busy", study, []), study.experiment.seeds)("runs", 8)
    job = page.finished({"kind": "sweep", "source": "folder", "experiment": "busy"})
    assert (job["state"], f"process {os.getpid()} is running" in job["text"]) == ("failed", True)
