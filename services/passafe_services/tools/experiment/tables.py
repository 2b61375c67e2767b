"""Results as tables: one row a run, one row a cell, one row a boundary; CSV and Parquet."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
from passafe_protocol.messages import FilterStatus
from pyarrow import csv, parquet
from pydantic import JsonValue

from passafe_services.tools.experiment.cells import displayed
from passafe_services.tools.experiment.live_agreement import Agreement
from passafe_services.tools.experiment.metrics import NUMERIC
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.summary import ExperimentSummary, in_order

Row = Mapping[str, Any]


def runs_table(plan: Plan) -> pa.Table:
    """Return a row for every run that is known, in the order of cells and seeds.

    Columns: ``variant``, the axes, ``seed``, the metrics of ``Metrics`` (statuses as ``ticks_…``, properties as
    ``holds_…``, the last state as ``final_x0`` …), whether each criterion is kept as ``keeps_…``, ``error`` and
    ``wall_s``.
    """
    return _table([_run_row(result, plan) for result in sorted(plan.results.values(), key=in_order)])


def cells_table(summary: ExperimentSummary) -> pa.Table:
    """Return a row for every cell.

    Columns: ``variant``, the axes with listed values, the bisected one, ``runs``, ``errors``, ``…_min``, ``…_median``
    and ``…_max`` of every metric, and for every criterion and the verdict the share of runs that break it,
    ``breaks_…``, with the ends of its 95 % interval (Wilson 1927), ``breaks_…_low`` and ``breaks_…_high``.
    """
    rows = []
    for one in summary.cells:
        row: dict[str, Any] = {"variant": one.cell.variant, **_plain(one.cell.values)}
        if summary.axis is not None:
            row[summary.axis] = one.probe
        row |= {"runs": one.runs, "errors": one.errors}
        for name, spread in one.metrics.items():
            for part in ("min", "median", "max"):
                row[f"{name}_{part}"] = None if spread is None else getattr(spread, part)
        for name, share in one.breaking.items():
            column = f"breaks_{name}"
            row |= {column: share.kept / share.of, f"{column}_low": share.low, f"{column}_high": share.high}
        rows.append(row | {"worst_seed": one.worst.seed})
    return _table(rows)


def boundaries_table(summary: ExperimentSummary) -> pa.Table:
    """Return a row for every cell and criterion: between which values of the bisected axis it first fails."""
    return _table(
        [
            {
                "variant": one.cell.variant,
                **_plain(one.cell.values),
                "criterion": name,
                "holds_up_to": boundary.holds_up_to,
                "fails_from": boundary.fails_from,
                "monotone": boundary.monotone,
                "tried": boundary.tried,
                "in_words": boundary.describe(),
            }
            for one in summary.boundaries
            for name, boundary in one.boundaries.items()
        ]
    )


def agreement_table(found: Sequence[Agreement]) -> pa.Table:
    """Return a row for every metric of every run that was made both live and in lockstep."""
    return _table([one._asdict() | {"agrees": one.agrees} for one in found])


def write_tables(tables: Mapping[str, pa.Table], folder: Path) -> list[Path]:
    """Write each table as CSV and as Parquet; return the files."""
    written = []
    for name, table in tables.items():
        csv.write_csv(table, folder / f"{name}.csv")
        parquet.write_table(table, folder / f"{name}.parquet")
        written += [folder / f"{name}.csv", folder / f"{name}.parquet"]
    return written


def write_summary(plan: Plan, summary: ExperimentSummary, agreement: Sequence[Agreement], folder: Path) -> None:
    """Write all tables of an experiment, and its summary as JSON."""
    tables = {"runs": runs_table(plan), "cells": cells_table(summary)}
    if summary.boundaries:
        tables["boundaries"] = boundaries_table(summary)
    if agreement:
        tables["agreement"] = agreement_table(agreement)
    write_tables(tables, folder)
    (folder / "summary.json").write_text(summary.model_dump_json(indent=2), encoding="utf-8")


def _run_row(result: RunResult, plan: Plan) -> dict[str, Any]:
    run, metrics = result.run, result.metrics
    row: dict[str, Any] = {"variant": run.variant, **_plain(run.values), "seed": run.seed}
    row |= {name: None if metrics is None else metrics.number(name) for name in NUMERIC}
    row |= {name: getattr(metrics, name, None) for name in ("h_min_barrier", "verdict")}
    counts = {} if metrics is None else metrics.status_counts
    row |= {f"ticks_{status.name}": counts.get(status.name, 0) for status in FilterStatus}
    if metrics is not None:
        row |= {f"holds_{name}": holds for name, holds in metrics.properties.items()}
        row |= {f"final_x{k}": value for k, value in enumerate(metrics.final_x or ())}
    row |= {f"keeps_{name}": criterion.holds(metrics) for name, criterion in plan.experiment.criteria.items()}
    return row | {"error": result.error, "wall_s": result.wall_s}


def _plain(values: Mapping[str, JsonValue]) -> dict[str, Any]:
    """Return values of axes as numbers, truths or text."""
    return {
        name: value if isinstance(value, bool | int | float | str) else displayed(value)
        for name, value in values.items()
    }


def _table(rows: Sequence[Row]) -> pa.Table:
    names = list(dict.fromkeys(name for row in rows for name in row))
    return pa.table({name: _column([row.get(name) for row in rows]) for name in names})


def _column(values: Iterable[Any]) -> pa.Array:
    """Return values as a column of one type: text where they are of several that are not all numbers."""
    found = list(values)
    kinds = {type(value) for value in found if value is not None}
    if kinds == {int, float}:
        return pa.array([None if value is None else float(value) for value in found], type=pa.float64())
    if len(kinds) > 1:
        return pa.array([None if value is None else str(value) for value in found], type=pa.string())
    return pa.array(found)
