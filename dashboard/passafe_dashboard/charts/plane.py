"""Make the chart of the robot in its plane: trail, place now, and regions to keep out of."""

from collections.abc import Sequence
from typing import Final

from bokeh.models import ColumnDataSource, DataRange1d, Line, Model, Scatter
from bokeh.models.annotations import LegendItem
from bokeh.plotting import figure
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier

from passafe_dashboard.charts.regions import draw_regions
from passafe_dashboard.charts.style import add_legend, key, plain_chart
from passafe_dashboard.columns import PLACES
from passafe_dashboard.palette import INK, LINE_COLOURS, PAPER, TRAIL_COLOUR

TRAILS: Final = ((TRAIL_COLOUR, "solid"), (LINE_COLOURS[1], "dashed"))
"""Colour and dash of each point's trail."""


def plane_chart(
    barriers: tuple[SingleBarrier, ...],
    *,
    trail: ColumnDataSource,
    robot: ColumnDataSource,
    starts: Sequence[tuple[float, float]],
    height: int = 560,
) -> figure:
    """Return the chart of outlines, trail and robot, with equal scales; barriers without outline are not drawn.

    Args:
        barriers: Every barrier.
        trail: Columns ``PLACES`` of every point, in order of time, m.
        robot: The same columns with one row, the newest positions.
        starts: Place of every point at the begin of the run, m.
        height: Height in pixels.
    """
    chart = plain_chart(
        name="plane",
        x_label="position p₁ (m)",
        y_label="position p₂ (m)",
        height=height,
        match_aspect=True,
    )
    regions = draw_regions(chart, barriers)
    items, drawn = list(regions.legend), list(regions.in_view)
    for number, start in enumerate(starts):
        which = f" {number + 1}" if len(starts) > 1 else ""
        more_items, more_drawn = _draw_point(chart, number, which, trail, robot, start)
        items += more_items
        drawn += more_drawn
    add_legend(chart, items, columns=4)
    chart.x_range = DataRange1d(renderers=drawn, range_padding=0.12)
    chart.y_range = DataRange1d(renderers=drawn, range_padding=0.12)
    return chart


def _draw_point(
    chart: figure,
    number: int,
    which: str,
    trail: ColumnDataSource,
    robot: ColumnDataSource,
    start: tuple[float, float],
) -> tuple[list[LegendItem], list[Model]]:
    """Draw trail, start and newest place of one point; return its legend entries and the renderers in view."""
    p1, p2 = PLACES[number]
    colour, dash = TRAILS[number]
    line = Line(x=p1, y=p2, line_color=colour, line_dash=dash, line_width=2)
    begin = Scatter(x=p1, y=p2, marker="square", size=9, fill_color=PAPER, line_color=INK)
    dot = Scatter(x=p1, y=p2, marker="circle", size=13, fill_color=colour, line_color=PAPER)
    drawn: list[Model] = [
        chart.add_glyph(trail, line),
        chart.add_glyph(ColumnDataSource({p1: [start[0]], p2: [start[1]]}), begin),
        chart.add_glyph(robot, dot),
    ]
    items = [key(chart, f"trail{which}", line), key(chart, f"robot{which}", dot)]
    if number == 0:
        items.insert(1, key(chart, "start", begin))
    return items, drawn
