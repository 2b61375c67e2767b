"""From results to files: resumption, tables, summaries, logs of single runs."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from passafe_services.tools.experiment.kept_logs import chosen, write_log
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import experiment_results
from passafe_services.tools.experiment.runner import StudyRunner
from passafe_services.tools.experiment.summary import ExperimentSummary
from passafe_services.tools.experiment.tables import boundaries_table, cells_table, runs_table, write_tables
from passafe_services.tools.feasibility.share import Share
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.runs.errors import ResultsFileError
from pyarrow import csv, parquet
from studies import DELAY, study

MODES: dict[str, Any] = {"off": {"filter.mode": "off"}, "both": {}}


def swept(**fields: object) -> Study:
    """Unprotected and protected, from just outside the disk and on the way into it."""
    at_the_disk = {"plant.x0": [1.3, 0.0, -2.0, 0.0], "links.plant-to-filter.loss": 0.2}
    defaults: dict[str, object] = {"variants": MODES, "axes": [DELAY], "seeds": {"count": 2}}
    return study(duration_s=0.4, overrides=at_the_disk, **(defaults | fields))


def done(one: Study) -> Plan:
    plan, runner = Plan(one.experiment), StudyRunner(one)
    waiting = list(plan.first())
    while waiting:
        waiting += plan.after(runner.result(waiting.pop(0)))
    return plan


@pytest.fixture(scope="module")
def finished() -> tuple[Study, Plan]:
    one = swept()
    return one, done(one)


def test_more_seeds_and_another_title_resume_the_same_results(finished: tuple[Study, Plan], tmp_path: Path) -> None:
    one, plan = finished
    path = tmp_path / "r.jsonl"
    list(experiment_results(path, one).add([list(plan.results.values())]))
    more = swept(seeds={"count": 5}, title="In other words")

    again = experiment_results(path, more)

    assert again.results == plan.results
    assert len(list(Plan(more.experiment, again.results).first())) == 4 * 5 - 4 * 2


@pytest.mark.parametrize("other", [{"tracking": True}, {"axes": []}, {"start": "random"}, {"variants": {"both": {}}}])
def test_results_of_another_experiment_are_refused(other: dict[str, Any], tmp_path: Path) -> None:
    experiment_results(tmp_path / "r.jsonl", swept())

    with pytest.raises(ResultsFileError, match="results of another experiment or version"):
        experiment_results(tmp_path / "r.jsonl", swept(**other))


def test_a_folder_is_no_results_file(tmp_path: Path) -> None:
    with pytest.raises(ResultsFileError, match="Is a directory"):
        experiment_results(tmp_path, swept())


def test_results_of_a_changed_scenario_are_refused(tmp_path: Path) -> None:
    one = swept()
    experiment_results(tmp_path / "r.jsonl", one)
    changed = one.model_copy(update={"scenario": one.scenario | {"rate_hz": 500.0}})

    with pytest.raises(ResultsFileError, match="results of another experiment or version"):
        experiment_results(tmp_path / "r.jsonl", changed)


def test_one_row_a_run_the_same_as_csv_and_as_parquet(finished: tuple[Study, Plan], tmp_path: Path) -> None:
    _, plan = finished
    write_tables({"runs": runs_table(plan)}, tmp_path)
    text, columns = csv.read_csv(tmp_path / "runs.csv"), parquet.read_table(tmp_path / "runs.parquet")

    assert columns.num_rows == text.num_rows == 8
    assert text.column_names == columns.column_names
    assert columns["variant"].to_pylist() == ["off"] * 4 + ["both"] * 4
    assert columns["delay_s"].to_pylist() == [0.0, 0.0, 0.01, 0.01] * 2
    assert columns["seed"].to_pylist() == [0, 1] * 4
    assert text["h_min"].to_pylist() == columns["h_min"].to_pylist()
    by_key = {(r.run.variant, r.run.values["delay_s"], r.run.seed): r.metrics for r in plan.results.values()}
    for row in columns.to_pylist():
        metrics = by_key[row["variant"], row["delay_s"], row["seed"]]
        assert metrics is not None
        assert row["h_min"] == metrics.h_min
        assert row["final_x0"] == (metrics.final_x or ())[0]
        assert row["ticks_PASSED"] == metrics.status_counts.get("PASSED", 0)
        assert row["holds_safe"] == metrics.properties["safe"]
        assert row["keeps_safe"] == (row["h_min"] >= 0)
        assert row["error"] == ""


def test_cells_have_spread_share_and_its_interval(finished: tuple[Study, Plan]) -> None:
    _, plan = finished
    summary = ExperimentSummary.of(plan)
    rows = cells_table(summary).to_pylist()
    runs = runs_table(plan).to_pylist()

    assert [(row["variant"], row["delay_s"], row["runs"]) for row in rows] == [
        ("off", 0.0, 2), ("off", 0.01, 2), ("both", 0.0, 2), ("both", 0.01, 2)
    ]  # fmt: skip
    for row in rows:
        of_cell = [run for run in runs if (run["variant"], run["delay_s"]) == (row["variant"], row["delay_s"])]
        h = [run["h_min"] for run in of_cell]
        assert (row["h_min_min"], row["h_min_max"]) == (min(h), max(h))
        assert row["h_min_median"] == pytest.approx(sum(h) / 2)
        assert row["worst_seed"] == min(of_cell, key=lambda run: run["h_min"])["seed"]
    assert [row["breaks_safe"] for row in rows] == [1.0, 1.0, 0.0, 0.0]
    # Wilson's interval for 0 of 2 with z = 1.96: from 0 to z²/(2 + z²).
    assert rows[2]["breaks_safe_low"] == 0.0
    assert rows[2]["breaks_safe_high"] == pytest.approx(1.959964**2 / (2 + 1.959964**2), rel=1e-6)


def test_runs_that_end_with_an_error_break_every_criterion() -> None:
    plan = done(swept(axes=[{"key": "plant.parameters.sigma", "values": [1.0, -1.0]}], seeds={"count": 1}))
    summary = ExperimentSummary.of(plan)

    assert (summary.runs, summary.errors) == (4, 2)
    broken = summary.cells[1]
    assert (broken.errors, broken.metrics["h_min"]) == (1, None)
    assert broken.breaking["safe"] == broken.breaking["verdict"] == Share.counted(1, 1)
    assert "sigma" in runs_table(plan).to_pylist()[1]["error"]


def test_values_of_every_kind_are_columns() -> None:
    axes = [
        {"key": "filter.between_samples", "values": [True, False]},
        {"key": "operator.source", "values": [{"kind": "constant", "value": [-1.0, 0.0]}]},
        {"key": "plant.playout_s", "values": [0, 0.01]},
    ]
    table = runs_table(done(swept(variants={"both": {}}, axes=axes, seeds={"count": 1})))

    assert table.schema.field("filter.between_samples").type == pa.bool_()
    assert table.schema.field("plant.playout_s").type == pa.float64()
    assert table["operator.source"].to_pylist() == ["constant, [-1.0, 0.0]"] * 4


def test_boundaries_are_a_row_for_each_cell_and_criterion() -> None:
    # The closer to the disk an unprotected robot begins, the deeper it gets.
    axis = {"name": "x", "kind": "bisect", "key": "plant.x0.0", "low": 1.0, "high": 2.0, "tolerance": 0.1}
    criteria = {"deep": {"metric": "h_min", "at_most": -0.3}, "solvent": {"metric": "tank_min_j", "at_least": 0.0}}
    summary = ExperimentSummary.of(
        done(swept(axes=[axis], variants={"off": {"filter.mode": "off"}}, criteria=criteria))
    )
    deep, solvent = boundaries_table(summary).to_pylist()

    assert (deep["variant"], deep["criterion"], solvent["criterion"]) == ("off", "deep", "solvent")
    assert deep["holds_up_to"] < deep["fails_from"] <= deep["holds_up_to"] + 0.1
    assert deep["tried"] == solvent["tried"] > 5
    assert [cell.probe for cell in summary.cells] == sorted(cell.probe or 0 for cell in summary.cells)


def test_the_kept_log_of_the_worst_run_is_the_same_run(finished: tuple[Study, Plan], tmp_path: Path) -> None:
    one, plan = finished
    worst = chosen(plan, "worst", 20)

    assert [result.run.cell for result in worst[:2]] in ([0, 1], [1, 0])  # unprotected: the worst of all
    assert sorted(result.run.cell for result in worst) == [0, 1, 2, 3]
    kept = write_log(StudyRunner(one), worst[0], tmp_path)
    assert kept.differing == ()
    assert RunLog.read(kept.path).identity.scenario.filter.mode == "off"


def test_a_log_of_another_run_is_found_out(finished: tuple[Study, Plan], tmp_path: Path) -> None:
    one, plan = finished
    [first, *_] = chosen(plan, "worst", 1)
    assert first.metrics is not None
    doctored = first.model_copy(update={"metrics": first.metrics.model_copy(update={"h_min": 0.5, "ticks": 1})})

    assert write_log(StudyRunner(one), doctored, tmp_path).differing == ("h_min", "ticks")


def test_the_worst_of_failed_runs_are_kept(finished: tuple[Study, Plan]) -> None:
    _, plan = finished
    failed = chosen(plan, "failed", 20)

    assert [result.run.variant for result in failed] == ["off"] * 4
    assert chosen(plan, "failed", 2) == failed[:2]
    assert [r.metrics.h_min for r in failed if r.metrics] == sorted(r.metrics.h_min or 0 for r in failed if r.metrics)
    assert chosen(plan, "none", 20) == []
