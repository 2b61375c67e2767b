"""Make the HTML report of an experiment: one file that needs neither network nor server."""

from base64 import b64encode
from collections.abc import Sequence
from typing import Final, NamedTuple

from passafe_services.scenarios.info import versions
from passafe_services.tools.experiment.cells import Cell, displayed
from passafe_services.tools.experiment.live_agreement import Agreement
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.summary import CellSummary, ExperimentSummary
from passafe_services.tools.feasibility.share import Share

from passafe_dashboard.markup import TEMPLATES, report_css
from passafe_dashboard.number_text import number
from passafe_dashboard.pictures.line_chart import LineChart, line_chart_picture
from passafe_dashboard.reports.experiment_charts import charts_of

MOST_ROWS: Final = 2000
"""Rows of cells that the page shows; the tables beside it have them all."""


class ChartImage(NamedTuple):
    """Image of a chart as a data URL, and its description."""

    source: str
    description: str


class KeptLine(NamedTuple):
    """One line of the table of kept logs, as text."""

    cell: str
    seed: int
    file: str
    metric: str


def experiment_page(
    plan: Plan, summary: ExperimentSummary, kept: Sequence[KeptLine], agreement: Sequence[Agreement] = ()
) -> str:
    """Return the page as HTML that refers to no other host, and to no other file but the logs that were kept.

    Args:
        plan: The experiment with its results.
        summary: Summary of the results.
        kept: Logs of single runs.
        agreement: Metrics of runs that were made live too.
    """
    experiment = plan.experiment
    return TEMPLATES.get_template("experiment.html").render(
        experiment=experiment,
        summary=summary,
        criteria={name: str(criterion) for name, criterion in experiment.criteria.items()},
        metrics=list(dict.fromkeys(criterion.metric for criterion in experiment.criteria.values())),
        cells=summary.cells[:MOST_ROWS],
        left_out=max(0, len(summary.cells) - MOST_ROWS),
        cell_values=_values,
        number=number,
        percent=_percent,
        spread=_spread,
        charts=[_image_of(chart) for chart in charts_of(plan, summary)],
        kept=kept,
        agreement=agreement,
        configuration=experiment.model_dump_json(indent=2),
        versions=versions(),
        css=report_css(),
    )


def _image_of(chart: LineChart) -> ChartImage:
    """Return a chart as an image of its own, so that identifiers of one picture do not clash with another's."""
    title = f"{chart.y_label} over {chart.x_label}"
    svg = line_chart_picture([chart], columns=1, title=title, description=chart.description)
    return ChartImage(f"data:image/svg+xml;base64,{b64encode(svg.encode()).decode()}", chart.description)


def _values(cell: Cell) -> list[str]:
    return [cell.variant, *(displayed(value) for value in cell.values.values())]


def _percent(share: Share) -> str:
    return f"{100 * share.kept / share.of:.3g} % ({100 * share.low:.3g} to {100 * share.high:.3g})"


def _spread(cell: CellSummary, metric: str) -> str:
    spread = cell.metrics[metric]
    return "unknown" if spread is None else f"{number(spread.min)} / {number(spread.median)} / {number(spread.max)}"
