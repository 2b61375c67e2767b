"""Choose the charts of an experiment: each criterion's metric over the axes, or the boundary where it first fails."""

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import Final, TypeVar

from passafe_services.tools.experiment.axes import BisectAxis, GridAxis, RandomAxis
from passafe_services.tools.experiment.bisection import Boundary
from passafe_services.tools.experiment.cells import displayed
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.schema import Criterion, Experiment
from passafe_services.tools.experiment.summary import CellBoundaries, CellSummary, ExperimentSummary, in_order
from pydantic import JsonValue

from passafe_dashboard.pictures.line_chart import Curve, LineChart

MOST_CHARTS: Final = 40
MOST_POINTS: Final = 2000
"""Points of a scatter chart for each variant; of more, evenly spread ones are drawn."""

C = TypeVar("C", CellSummary, CellBoundaries)


def charts_of(plan: Plan, summary: ExperimentSummary) -> list[LineChart]:
    """Return the charts of an experiment, no more than ``MOST_CHARTS``."""
    drawn = [
        *boundary_charts(plan.experiment, summary),
        *_spread_charts(plan.experiment, summary),
        *_scatter_charts(plan),
    ]
    return drawn[:MOST_CHARTS]


def boundary_charts(experiment: Experiment, summary: ExperimentSummary) -> list[LineChart]:
    """Return a chart for each criterion and each combination of the other listed axes: boundary over one axis."""
    axis, over = experiment.bisected, _longest(experiment)
    if axis is None or over is None:
        return []
    return [
        LineChart(
            x_label=f"{over.name}{where}",
            y_label=f"{name} up to {axis.name}",
            curves=tuple(_boundary_curve(cells, name, over, axis, experiment) for cells in variants),
            limit=axis.high,
            limit_label="not tried beyond",
            least=axis.low,
        )
        for name in experiment.criteria
        for where, variants in _panels(summary.boundaries, over)
    ]


def _spread_charts(experiment: Experiment, summary: ExperimentSummary) -> list[LineChart]:
    """Return a chart for each criterion's metric: its median with a band from the lowest to the highest run."""
    over = _longest(experiment)
    if experiment.bisected is not None or over is None:
        return []
    return [
        LineChart(
            x_label=f"{over.name}{where}",
            y_label=criterion.metric,
            curves=tuple(_spread_curve(cells, criterion.metric, over, experiment) for cells in variants),
            limit=_limit(criterion),
            limit_label=f"limit of {name}",
        )
        for name, criterion in experiment.criteria.items()
        for where, variants in _panels(summary.cells, over)
    ]


def _scatter_charts(plan: Plan) -> Iterator[LineChart]:
    """Yield a chart for each criterion's metric and each axis that is drawn at random: a point a run."""
    runs = sorted(plan.results.values(), key=in_order)
    for axis in plan.experiment.random:
        for name, criterion in plan.experiment.criteria.items():
            curves = tuple(
                _scatter([one for one in runs if one.run.variant == variant], variant, style, axis, criterion)
                for style, variant in enumerate(plan.experiment.variants)
            )
            if any(curve.x for curve in curves):
                yield LineChart(
                    x_label=axis.name,
                    y_label=criterion.metric,
                    curves=curves,
                    limit=_limit(criterion),
                    limit_label=f"limit of {name}",
                    points=True,
                )


def _scatter(runs: Sequence[RunResult], variant: str, style: int, axis: RandomAxis, criterion: Criterion) -> Curve:
    found = [
        (one.run.values[axis.name], None if one.metrics is None else one.metrics.number(criterion.metric))
        for one in runs
    ]
    known = [(_number(x), y) for x, y in found if _is_number(x) and y is not None and isfinite(y)]
    drawn = known[:: -(-len(known) // MOST_POINTS) or 1]
    return Curve(label=variant, style=style, x=tuple(x for x, _ in drawn), y=tuple(y for _, y in drawn))


def _longest(experiment: Experiment) -> GridAxis | None:
    """Return the axis to draw along: of those whose values are all numbers, the one that has most."""
    numbers = [axis for axis in experiment.grid if all(map(_is_number, axis.values))]
    return max(numbers, key=lambda axis: len(axis.values), default=None)


def _panels(cells: Sequence[C], over: GridAxis) -> Iterator[tuple[str, list[list[C]]]]:
    """Yield the values of the other axes, in words, with their cells: a list a variant, in order of the axis."""
    found: dict[str, dict[str, list[C]]] = {}
    for one in cells:
        others = [f"{name} = {displayed(value)}" for name, value in one.cell.values.items() if name != over.name]
        where = f", where {', '.join(others)}" if others else ""
        found.setdefault(where, {}).setdefault(one.cell.variant, []).append(one)
    for where, variants in found.items():
        yield where, [sorted(curve, key=lambda one: _place(one, over)) for curve in variants.values()]


def _place(one: CellSummary | CellBoundaries, over: GridAxis) -> float:
    return _number(one.cell.values[over.name])


def _boundary_curve(
    cells: Sequence[CellBoundaries], name: str, over: GridAxis, axis: BisectAxis, experiment: Experiment
) -> Curve:
    tried = [one for one in cells if one.boundaries[name].tried]
    boundaries = [one.boundaries[name] for one in tried]
    variant = cells[0].cell.variant
    return Curve(
        label=variant,
        style=list(experiment.variants).index(variant),
        x=tuple(_place(one, over) for one in tried),
        y=tuple(_height(boundary, axis) for boundary in boundaries),
        open_at=tuple(k for k, boundary in enumerate(boundaries) if boundary.fails_from is None),
        doubtful_at=tuple(k for k, boundary in enumerate(boundaries) if not boundary.monotone),
    )


def _height(boundary: Boundary, axis: BisectAxis) -> float:
    """Return the largest value that holds: what is drawn is never more than was seen."""
    if boundary.fails_from is None:
        return axis.high
    return axis.low if boundary.holds_up_to is None else boundary.holds_up_to


def _spread_curve(cells: Sequence[CellSummary], metric: str, over: GridAxis, experiment: Experiment) -> Curve:
    points = [
        (_place(one, over), spread)
        for one in cells
        if (spread := one.metrics[metric]) is not None and all(map(isfinite, (spread.min, spread.median, spread.max)))
    ]
    variant = cells[0].cell.variant
    return Curve(
        label=variant,
        style=list(experiment.variants).index(variant),
        x=tuple(x for x, _ in points),
        y=tuple(spread.median for _, spread in points),
        low=tuple(spread.min for _, spread in points),
        high=tuple(spread.max for _, spread in points),
    )


def _limit(criterion: Criterion) -> float | None:
    return criterion.at_least if criterion.at_most is None else criterion.at_most


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def _number(value: JsonValue) -> float:
    return float(value) if isinstance(value, int | float) else 0.0
