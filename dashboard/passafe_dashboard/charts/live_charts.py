"""Make all charts of the live page in one document, with the script that embeds them."""

from dataclasses import dataclass
from functools import lru_cache
from math import nan
from typing import Final

from bokeh.embed import components
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure

from passafe_dashboard.charts.barriers import chain_chart, h_chart
from passafe_dashboard.charts.energy import power_margin_chart, tank_chart
from passafe_dashboard.charts.over_time import live_range
from passafe_dashboard.charts.plane import plane_chart
from passafe_dashboard.charts.timeline import age_chart, status_chart
from passafe_dashboard.columns import START, TIME, ZERO, ColumnLayout, drawn_columns

TICKS: Final = "ticks"
STATES: Final = "states"
ROBOT: Final = "robot"
"""Names under which the page's script finds the tables in the document."""


@dataclass(frozen=True, kw_only=True)
class LiveCharts:
    """Charts of the live page.

    Attributes:
        script: JavaScript that draws them.
        divs: Markup of the place of each chart, by the chart's name.
    """

    script: str
    divs: dict[str, str]


@lru_cache(maxsize=4)
def live_charts(layout: ColumnLayout, *, starts: tuple[tuple[float, float], ...], window_s: float) -> LiveCharts:
    """Return the charts of the live page without data.

    Args:
        layout: Columns of the scenario.
        starts: Place of each point in the plane at the begin of the run, m; without a point there is no plane.
        window_s: Stretch of time that the charts show.
    """
    ticks = unfilled_table(TICKS, drawn_columns(tuple(layout.tick_columns), layout.log_columns))
    states = unfilled_table(STATES, drawn_columns(tuple(layout.state_columns), ()))
    robot = unfilled_table(ROBOT, layout.place_columns)
    x_range = live_range(window_s)
    charts: list[figure] = [
        power_margin_chart(source=ticks, x_range=x_range),
        tank_chart(ticks=ticks, x_range=x_range),
        status_chart(source=ticks, x_range=x_range),
        age_chart(ticks=ticks, x_range=x_range),
    ]
    if starts:
        charts.append(plane_chart(layout.barriers, trail=states, robot=robot, starts=starts))
    if layout.barriers:
        charts.append(h_chart(layout, ticks=ticks, states=states, x_range=x_range))
    chain = chain_chart(layout, ticks=ticks, x_range=x_range)
    if chain is not None:
        charts.append(chain)
    script, divs = components({str(chart.name): chart for chart in charts}, wrap_script=False)
    return LiveCharts(script=script, divs=divs)


def unfilled_table(name: str, columns: tuple[str, ...]) -> ColumnDataSource:
    """Return a table with one empty row at time 0: a chart without a row has no range and no legend."""
    at_zero = {START, TIME, ZERO}
    return ColumnDataSource(name=name, data={column: [0.0 if column in at_zero else nan] for column in columns})
