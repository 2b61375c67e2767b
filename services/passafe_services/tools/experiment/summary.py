"""What the cells of an experiment came to: spread of every figure, shares that break a criterion, boundaries."""

from collections.abc import Sequence
from functools import partial
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict

from passafe_services.tools.experiment.bisection import Boundary
from passafe_services.tools.experiment.metrics import NUMERIC
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runs import Cell, Result, RunKey
from passafe_services.tools.experiment.schema import Criterion, Experiment
from passafe_services.tools.feasibility.share import Share

VERDICT = "verdict"
"""Beside the criteria: runs whose verdict is not that every required property holds."""


class MetricSpread(BaseModel):
    """A figure over the runs of a cell that have it."""

    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="constants")

    min: float
    median: float
    max: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Self | None:
        """Return the spread of some values; ``None`` of none."""
        if not values:
            return None
        low, high = min(values), max(values)
        return cls(min=low, median=float(np.median(values)) if np.isfinite((low, high)).all() else low, max=high)


class CellSummary(BaseModel):
    """What the runs of one cell came to, at one value of the bisected axis where there is one.

    Attributes:
        cell: The cell.
        probe: That value.
        runs: How many.
        errors: How many could not be run.
        figures: MetricSpread of every figure, by name; ``None`` where no run has it.
        breaking: Share of the runs that break each criterion, by its name, and ``verdict``; errors break all.
        worst: Seed of the worst run by the experiment's ``worst_by``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="constants")

    cell: Cell
    probe: float | None
    runs: int
    errors: int
    figures: dict[str, MetricSpread | None]
    breaking: dict[str, Share]
    worst: RunKey

    @classmethod
    def of(cls, cell: Cell, results: Sequence[Result], experiment: Experiment) -> Self:
        """Sum up at least one run of a cell, all at the same value of the bisected axis."""
        ran = [result.figures for result in results if result.figures is not None]
        values = {name: [figures.number(name) for figures in ran] for name in NUMERIC}
        breaking = {
            name: sum(not criterion.holds(result.figures) for result in results)
            for name, criterion in experiment.criteria.items()
        }
        breaking[VERDICT] = sum(result.figures is None or result.figures.verdict != "holds" for result in results)
        return cls(
            cell=cell,
            probe=results[0].run.probe,
            runs=len(results),
            errors=len(results) - len(ran),
            figures={name: MetricSpread.of([v for v in found if v is not None]) for name, found in values.items()},
            breaking={name: Share.counted(count, len(results)) for name, count in breaking.items()},
            worst=worst_of(results, experiment.worst).run.key,
        )


class CellBoundaries(BaseModel):
    """Where each criterion first fails in one cell, by the criterion's name."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    cell: Cell
    boundaries: dict[str, Boundary]


class ExperimentSummary(BaseModel):
    """What an experiment came to.

    Attributes:
        name: The experiment's.
        runs: How many runs, all cells together.
        errors: How many could not be run.
        values: Names of the axes with listed values.
        axis: Name of the bisected axis.
        cells: Every cell that has runs, in order; with a bisected axis once for each value that was tried.
        boundaries: Of every cell, where an axis is bisected.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="constants")

    name: str
    runs: int
    errors: int
    values: tuple[str, ...]
    axis: str | None
    cells: tuple[CellSummary, ...]
    boundaries: tuple[CellBoundaries, ...]

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """Sum up what is known of an experiment."""
        experiment = plan.experiment
        found: dict[tuple[int, float | None], list[Result]] = {}
        for result in sorted(plan.results.values(), key=in_order):
            found.setdefault((result.run.cell, result.run.probe), []).append(result)
        cells = tuple(CellSummary.of(plan.cells[number], runs, experiment) for (number, _), runs in found.items())
        return cls(
            name=experiment.name,
            runs=sum(cell.runs for cell in cells),
            errors=sum(cell.errors for cell in cells),
            values=tuple(axis.name for axis in experiment.grid),
            axis=None if experiment.bisected is None else experiment.bisected.name,
            cells=cells,
            boundaries=() if experiment.bisected is None else tuple(_boundaries(plan)),
        )


def in_order(result: Result) -> tuple[int, float, int]:
    """Return what puts results in the order of cells, values of the bisected axis, and seeds."""
    run = result.run
    return run.cell, float("-inf") if run.probe is None else run.probe, run.seed


def worst_of(results: Sequence[Result], criterion: Criterion) -> Result:
    """Return the run whose figure is furthest on the wrong side; the first of equal ones."""
    return min(results, key=partial(goodness, criterion=criterion))


def goodness(result: Result, criterion: Criterion) -> float:
    """Return how good the figure is that a criterion asks about; −∞ where a run has none."""
    value = None if result.figures is None else result.figures.number(criterion.figure)
    if value is None:
        return float("-inf")
    return value if criterion.at_most is None else -value


def _boundaries(plan: Plan) -> list[CellBoundaries]:
    return [
        CellBoundaries(cell=cell, boundaries={name: Boundary.of(holds) for name, holds in plan.holds(cell).items()})
        for cell in plan.cells
    ]
