"""The map of a sweep from its results, as they come."""

import json
from pathlib import Path

import pytest
from browsed_archive import browse_folder
from passafe_dashboard.archive.experiment_models import ExperimentView
from passafe_dashboard.archive.experiment_view import entry_of, view_of
from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.archive.sweep_reader import SweepReader
from passafe_dashboard.errors import ArchiveNameError
from passafe_dashboard.jobs.cell_run_work import repeat
from passafe_dashboard.jobs.job_progress import JobProgress
from passafe_dashboard.jobs.job_request import CellRunRequest
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.summary import ExperimentSummary
from passafe_services.tools.experiment.sweep_state import state_writer
from small_sweep import EXPERIMENT, small_results, small_study, write_results


@pytest.fixture(scope="module")
def study() -> Study:
    return small_study()


@pytest.fixture(scope="module")
def results(study: Study) -> list[RunResult]:
    return small_results(study)


def viewed(folder: Path, reader: SweepReader) -> ExperimentView:
    reader.look()
    view = view_of("small", folder, reader)
    assert view is not None
    return view


def test_the_map_fills_in_as_results_come(tmp_path: Path, study: Study, results: list[RunResult]) -> None:
    folder = write_results(tmp_path / "small", study, results[:3])
    reader = SweepReader(folder)
    before = viewed(folder, reader)
    assert before.entry.runs == 3
    assert sum(probe.runs for cell in before.cells for probe in cell.probes) == 3
    with (folder / "results.jsonl").open("a") as file:
        file.write(results[3].model_dump_json()[:-9])  # a line that is still being written
    assert viewed(folder, reader).entry.runs == 3
    with (folder / "results.jsonl").open("a") as file:
        file.write(results[3].model_dump_json()[-9:] + "\n")
    assert viewed(folder, reader).entry.runs == 4
    assert reader.trouble == ""


def test_the_map_says_what_the_summary_says(tmp_path: Path, study: Study, results: list[RunResult]) -> None:
    folder = write_results(tmp_path / "small", study, results)
    view = viewed(folder, SweepReader(folder))
    summary = ExperimentSummary.of(Plan(study.experiment, {result.run.key: result for result in results}))
    assert view.axes[0].values == ("0", "0.02")
    assert [cell.variant for cell in view.cells] == ["off", "off", "both", "both"]
    for cell, expected in zip(view.cells, summary.cells, strict=True):
        [probe] = cell.probes
        spread = expected.metrics["h_min"]
        assert spread is not None
        assert probe.runs == expected.runs == 2
        assert probe.breaking == {name: share.kept for name, share in expected.breaking.items()}
        assert (probe.low["h_min"], probe.high["h_min"]) == (spread.min, spread.max)
        assert probe.worst_seed == expected.worst.seed
        assert probe.log is None


def test_a_criterion_at_infinity_and_an_error_are_counted(
    tmp_path: Path, study: Study, results: list[RunResult]
) -> None:
    metrics = results[0].metrics
    assert metrics is not None
    high = results[0].model_copy(update={"metrics": metrics.model_copy(update={"u_norm_max": float("inf")})})
    failed = results[1].model_copy(update={"metrics": None, "error": "no start"})
    folder = write_results(tmp_path / "small", study, [high, failed])
    view = viewed(folder, SweepReader(folder))
    probes = [probe for cell in view.cells for probe in cell.probes]
    assert sum(probe.errors for probe in probes) == 1
    assert sum(probe.breaking["quick"] for probe in probes) == 2


def test_the_boundary_of_a_bisected_axis_is_in_words(tmp_path: Path, results: list[RunResult]) -> None:
    axis = {"kind": "bisect", "name": "k", "key": "filter.k_i", "low": 1.0, "high": 9.0, "steps": 2}
    study = small_study()
    changed = json.loads(study.experiment.model_dump_json()) | {"axes": [axis]}
    bisected = study.model_copy(update={"experiment": type(study.experiment).model_validate(changed)})
    metrics = results[0].metrics
    assert metrics is not None
    made = [
        results[0].model_copy(
            update={
                "run": results[0].run.model_copy(update={"cell": 1, "probe": probe, "seed": seed}),
                "metrics": metrics.model_copy(update={"h_min": 6.0 - probe}),
            }
        )
        for probe in (1.0, 3.0, 5.0)
        for seed in (0, 1)
    ]
    folder = write_results(tmp_path / "small", bisected, made[:5])
    assert viewed(folder, SweepReader(folder)).cells[1].boundaries["safe"] == "1 to 3"
    cell = viewed(folder, SweepReader(folder)).cells[1]
    assert [probe.probe for probe in cell.probes] == [1.0, 3.0, 5.0]


def test_a_sweep_says_at_which_stage_it_is(tmp_path: Path, study: Study, results: list[RunResult]) -> None:
    folder = write_results(tmp_path / "small", study, results)
    reader = SweepReader(folder)
    assert entry_of("small", folder, reader).stage == "unknown"
    note = state_writer(folder, study.experiment.seeds)
    note("runs", 8)
    found = entry_of("small", folder, reader)
    assert (found.stage, found.most_runs) == ("running", 8)
    note("finished", 8)
    assert entry_of("small", folder, reader).stage == "finished"
    state = json.loads((folder / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps(state | {"stage": "runs", "began_s": 1.0}))
    assert entry_of("small", folder, reader).stage == "interrupted"  # its process is another one by now


@pytest.mark.parametrize("text", ["", "no results\n", '{"schema_version": 2}\n', "\xff" * 10_000])
def test_results_that_cannot_be_read_are_named(tmp_path: Path, text: str) -> None:
    (tmp_path / "small").mkdir()
    (tmp_path / "small" / "results.jsonl").write_text(text)
    with browse_folder(tmp_path) as page:
        [entry] = page.get("/api/experiments").json()["experiments"]
        assert entry["trouble"] == "not the results of an experiment of this version"
        answer = page.get("/api/experiments/small")
        assert (answer.status_code, "not the results" in answer.text) == (404, True)


def test_a_cell_leads_to_its_worst_run(tmp_path: Path, study: Study, results: list[RunResult]) -> None:
    folder = write_results(tmp_path / "runs" / "small", study, results)
    assert EXPERIMENT["title"] == "Two modes"
    with browse_folder(folder.parent) as page:
        cell = page.get("/api/experiments/small").json()["cells"][1]
        seed = cell["probes"][0]["worst_seed"]
        request = {"kind": "cell-run", "experiment": "small", "cell": 1, "seed": seed}
        job = page.finished(request)
        assert (job["state"], job["text"]) == ("done", "done"), job
        assert job["log"] == f"small/logs/cell-1-seed-{seed}.mcap"
        assert page.get("/api/experiments/small").json()["cells"][1]["probes"][0]["log"] == job["log"]
        assert page.get(f"/api/logs/{job['log']}").json()["mode"] == "off"
        assert page.post(request | {"experiment": "../small"}).status_code == 404


def test_a_run_that_there_is_not_is_refused(tmp_path: Path, study: Study, results: list[RunResult]) -> None:
    write_results(tmp_path / "small", study, results)
    request = CellRunRequest(kind="cell-run", experiment="small", cell=1, seed=99)
    with pytest.raises(ArchiveNameError, match="cell 1, seed 99"):
        repeat(request, RunsFolder(tmp_path), JobProgress(lambda _: None))
