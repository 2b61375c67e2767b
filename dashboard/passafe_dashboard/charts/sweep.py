"""Charts of an experiment: a figure over what was varied, one line a variant."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from bokeh.models import ColumnDataSource, Patch, Scatter
from bokeh.models.annotations import LegendItem
from bokeh.plotting import figure

from passafe_dashboard.charts.style import add_legend, key, plain_figure, styled_line, zero_line
from passafe_dashboard.palette import PAPER, line_style

HEIGHT: Final = 300
BAND_ALPHA: Final = 0.12
LEAST_MARK: Final = 5
RING: Final = 2
"""How much larger the marks of the curve before are: where curves meet, all of them are seen."""

DOT: Final = 4
LEGEND_COLUMNS: Final = 3

X, Y = "x", "y"


@dataclass(frozen=True, kw_only=True)
class Curve:
    """One line of a chart.

    Attributes:
        label: Its name in the legend.
        style: Number of its colour and dash.
        x: Places, increasing.
        y: What is drawn there.
        low: Lower edge of a band around it, as long as ``x``; empty for none.
        high: Upper edge.
        open_at: Numbers of the points whose true place lies further up than they are drawn.
        doubtful_at: Numbers of the points that are not the whole truth.
    """

    label: str
    style: int
    x: tuple[float, ...]
    y: tuple[float, ...]
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    open_at: tuple[int, ...] = ()
    doubtful_at: tuple[int, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Chart:
    """What one chart of an experiment shows.

    Attributes:
        name: Unique among the charts of a page.
        x_label: What is varied.
        y_label: What is shown.
        curves: One for each variant.
        limit: Height of a line that matters, if there is one.
        limit_label: What it is.
        least: A height that is in view whatever the curves are, if there is one.
        points: Whether the curves are points without order, to be drawn without a line between them.
    """

    name: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    limit: float | None = None
    limit_label: str = ""
    least: float | None = None
    points: bool = False


def sweep_figure(chart: Chart) -> figure:
    """Return a chart; every curve has its place in the legend."""
    drawn = plain_figure(name=chart.name, x_label=chart.x_label, y_label=chart.y_label, height=HEIGHT)
    legend: list[LegendItem] = []
    for number, curve in enumerate(chart.curves):
        if chart.points:
            legend.append(_dots(drawn, curve))
            continue
        _band(drawn, curve)
        line = styled_line(X, Y, curve.style)
        drawn.add_glyph(_table(curve.x, curve.y), line)
        _marks(drawn, curve, LEAST_MARK + RING * (len(chart.curves) - 1 - number))
        legend.append(key(drawn, curve.label, line))
    places = [x for curve in chart.curves for x in curve.x]
    if chart.limit is not None and places:
        limit = zero_line(X, Y)
        limit.line_dash = "dotted"
        drawn.add_glyph(_table((min(places), max(places)), (chart.limit,) * 2), limit)
        legend.append(key(drawn, chart.limit_label, limit))
    if chart.least is not None and places:
        drawn.add_glyph(
            _table(places[:1], (chart.least,)), Scatter(x=X, y=Y, size=0, line_color=None, fill_color=PAPER)
        )
    add_legend(drawn, legend, columns=LEGEND_COLUMNS)
    return drawn


def _dots(drawn: figure, curve: Curve) -> LegendItem:
    colour, _ = line_style(curve.style)
    glyph = Scatter(x=X, y=Y, marker="circle", size=DOT, fill_color=colour, fill_alpha=0.5, line_color=None)
    drawn.add_glyph(_table(curve.x, curve.y), glyph)
    return key(drawn, curve.label, glyph)


def _band(drawn: figure, curve: Curve) -> None:
    if not curve.low:
        return
    colour, _ = line_style(curve.style)
    band = Patch(x=X, y=Y, fill_color=colour, fill_alpha=BAND_ALPHA, line_color=None)
    drawn.add_glyph(_table((*curve.x, *reversed(curve.x)), (*curve.low, *reversed(curve.high))), band)


def _marks(drawn: figure, curve: Curve, size: float) -> None:
    """Mark every point: hollow where its true place is further up, square where it is not the whole truth."""
    colour, _ = line_style(curve.style)
    for k, (x, y) in enumerate(zip(curve.x, curve.y, strict=True)):
        mark = Scatter(
            x=X,
            y=Y,
            marker="square" if k in curve.doubtful_at else "circle",
            size=size,
            line_color=colour,
            fill_color=PAPER if k in curve.open_at else colour,
        )
        drawn.add_glyph(_table((x,), (y,)), mark)


def _table(x: Sequence[float], y: Sequence[float]) -> ColumnDataSource:
    return ColumnDataSource({X: list(x), Y: list(y)})
