"""The summary of an experiment: spread of every metric, shares of runs that break a criterion, boundaries."""

from collections.abc import Sequence
from functools import partial
from typing import Self

from passafe_services.tools.experiment.bisection import Boundary
from passafe_services.tools.experiment.cells import Cell, RunKey
from passafe_services.tools.experiment.metrics import NUMERIC
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.schema import Criterion, Experiment
from passafe_services.tools.feasibility.share import Share
from passafe_services.tools.runs.record import SweepRecord
from passafe_services.tools.runs.summary import Spread, badness

VERDICT = "verdict"
"""Beside the criteria: runs whose verdict is not that every required property holds."""


class CellSummary(SweepRecord):
    """The summary of one cell's runs, at one value of the bisected axis where there is one.

    Attributes:
        cell: The cell.
        probe: That value.
        runs: How many.
        errors: How many could not be run.
        metrics: Spread of every metric, by name; ``None`` where no run has it.
        breaking: Share of the runs that break each criterion, by its name, and ``verdict``; errors break all.
        worst: Seed of the worst run by the experiment's ``worst_by``.
    """

    cell: Cell
    probe: float | None
    runs: int
    errors: int
    metrics: dict[str, Spread | None]
    breaking: dict[str, Share]
    worst: RunKey

    @classmethod
    def of(cls, cell: Cell, results: Sequence[RunResult], experiment: Experiment) -> Self:
        """Summarise at least one run of a cell, all at the same value of the bisected axis."""
        ran = [result.metrics for result in results if result.metrics is not None]
        breaking = {
            name: sum(not criterion.holds(result.metrics) for result in results)
            for name, criterion in experiment.criteria.items()
        }
        breaking[VERDICT] = sum(result.metrics is None or result.metrics.verdict != "holds" for result in results)
        return cls(
            cell=cell,
            probe=results[0].run.probe,
            runs=len(results),
            errors=len(results) - len(ran),
            metrics={name: Spread.of(metrics.number(name) for metrics in ran) for name in NUMERIC},
            breaking={name: Share.counted(count, len(results)) for name, count in breaking.items()},
            worst=worst_result(results, experiment.worst).run.key,
        )


class CellBoundaries(SweepRecord):
    """The boundaries of one cell: between which values each criterion first fails, by the criterion's name."""

    cell: Cell
    boundaries: dict[str, Boundary]


class ExperimentSummary(SweepRecord):
    """The summary of an experiment.

    Attributes:
        name: The experiment's.
        runs: How many runs, all cells together.
        errors: How many could not be run.
        values: Names of the axes with listed values.
        axis: Name of the bisected axis.
        cells: Every cell that has runs, in order; with a bisected axis once for each value that was tried.
        boundaries: Of every cell, where an axis is bisected.
    """

    name: str
    runs: int
    errors: int
    values: tuple[str, ...]
    axis: str | None
    cells: tuple[CellSummary, ...]
    boundaries: tuple[CellBoundaries, ...]

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """Summarise what is known of an experiment."""
        experiment = plan.experiment
        found: dict[tuple[int, float | None], list[RunResult]] = {}
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


def in_order(result: RunResult) -> tuple[int, float, int]:
    """Return the sort key that orders results by cell, value of the bisected axis, and seed."""
    run = result.run
    return run.cell, float("-inf") if run.probe is None else run.probe, run.seed


def worst_result(results: Sequence[RunResult], criterion: Criterion) -> RunResult:
    """Return the run whose metric is furthest on the wrong side of a criterion; the first of equal ones."""
    return max(results, key=partial(badness_of, criterion=criterion))


def badness_of(result: RunResult, criterion: Criterion) -> float:
    """Return how bad the metric is that a criterion asks about, the larger the worse; ∞ where a run has none."""
    value = None if result.metrics is None else result.metrics.number(criterion.metric)
    return badness(value, high_is_worse=criterion.at_most is not None)


def _boundaries(plan: Plan) -> list[CellBoundaries]:
    return [
        CellBoundaries(cell=cell, boundaries={name: Boundary.of(holds) for name, holds in plan.holds(cell).items()})
        for cell in plan.cells
    ]
