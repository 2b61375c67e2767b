"""The page of an experiment: one file that needs nothing else, and its charts as one picture."""

from base64 import b64encode
from collections.abc import Sequence
from typing import Final, NamedTuple

from passafe_services.scenarios.info import versions
from passafe_services.tools.experiment.live_agreement import Agreement
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runs import Cell, shown
from passafe_services.tools.experiment.summary import CellSummary, ExperimentSummary
from passafe_services.tools.feasibility.share import Share

from passafe_dashboard.charts.sweep import Chart, sweep_figure
from passafe_dashboard.markup import TEMPLATES, report_css
from passafe_dashboard.reports.experiment_charts import charts_of
from passafe_dashboard.reports.run_page import number
from passafe_dashboard.svg.chart import Placed, picture

WIDTH, HEIGHT = 470.0, 320.0
"""Of one chart."""

LEAST_ROWS: Final = 2000
"""Rows of cells that the page shows; the tables beside it have them all."""


class Drawn(NamedTuple):
    """A chart on the page: where its picture is, and what it shows for who cannot see it."""

    source: str
    text: str


class KeptLine(NamedTuple):
    """A log that was kept, in words."""

    cell: str
    seed: int
    file: str
    figure: str


def sweep_page(
    plan: Plan, summary: ExperimentSummary, kept: Sequence[KeptLine], agreement: Sequence[Agreement] = ()
) -> str:
    """Return the page as HTML that refers to no other host, and to no other file but the logs that were kept.

    Args:
        plan: The experiment with its results.
        summary: What they came to.
        kept: Logs of single runs.
        agreement: Figures of runs that were made live too.

    Raises:
        UndrawableError: A chart has a part that the picture writer does not know.
    """
    experiment = plan.experiment
    return TEMPLATES.get_template("experiment.html").render(
        experiment=experiment,
        summary=summary,
        criteria={name: str(criterion) for name, criterion in experiment.criteria.items()},
        figures=list(dict.fromkeys(criterion.figure for criterion in experiment.criteria.values())),
        cells=summary.cells[:LEAST_ROWS],
        left_out=max(0, len(summary.cells) - LEAST_ROWS),
        cell_values=_values,
        number=number,
        percent=_percent,
        spread=_spread,
        charts=[_drawn(chart) for chart in charts_of(plan, summary)],
        kept=kept,
        agreement=agreement,
        configuration=experiment.model_dump_json(indent=2),
        versions=versions(),
        css=report_css(),
    )


def sweep_picture(charts: Sequence[Chart], *, columns: int, title: str) -> str:
    """Return charts as one SVG, in rows of so many.

    Raises:
        UndrawableError: A chart has a part that the picture writer does not know.
    """
    placed = [
        Placed(sweep_figure(chart), WIDTH * (number % columns), HEIGHT * (number // columns), WIDTH, HEIGHT)
        for number, chart in enumerate(charts)
    ]
    return picture(
        placed,
        width=WIDTH * min(columns, len(placed)),
        height=HEIGHT * -(-len(placed) // columns),
        title=title,
        description=" ".join(_text(chart) for chart in charts),
    )


def _drawn(chart: Chart) -> Drawn:
    """Return a chart as an image of its own: names within one picture do not meet those of another."""
    svg = sweep_picture([chart], columns=1, title=f"{chart.y_label} over {chart.x_label}")
    return Drawn(f"data:image/svg+xml;base64,{b64encode(svg.encode()).decode()}", _text(chart))


def _text(chart: Chart) -> str:
    ends = "; ".join(
        f"{curve.label} from {number(curve.y[0])} at {number(curve.x[0])} to {number(curve.y[-1])} at "
        f"{number(curve.x[-1])}"
        for curve in chart.curves
        if curve.x and not chart.points
    )
    return f"{chart.y_label} over {chart.x_label}" + (f": {ends}." if ends else ".")


def _values(cell: Cell) -> list[str]:
    return [cell.variant, *(shown(value) for value in cell.values.values())]


def _percent(share: Share) -> str:
    return f"{100 * share.kept / share.of:.3g} % ({100 * share.low:.3g} to {100 * share.high:.3g})"


def _spread(cell: CellSummary, figure: str) -> str:
    spread = cell.figures[figure]
    return "unknown" if spread is None else f"{number(spread.min)} / {number(spread.median)} / {number(spread.max)}"
