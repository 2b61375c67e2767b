"""Draw line charts of an experiment: a metric or a boundary over what was varied, one curve a variant."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from passafe_dashboard.number_text import number
from passafe_dashboard.palette import PAPER, ZERO_COLOUR, line_style
from passafe_dashboard.pictures.svg_file import DASHES, add_legend, svg_text

WIDTH: Final = 470.0
HEIGHT: Final = 320.0
"""Of one chart, points."""

BAND_ALPHA: Final = 0.12
LEAST_MARK: Final = 5.0
RING: Final = 2.0
"""Difference of the marks' size between two curves: where curves meet, all of them are seen."""

LEGEND_COLUMNS: Final = 3

MOST_LINEAR: Final = 100.0
"""Ratio of ordinates above which small ones would lie on a limit of 0: the axis is then symmetric logarithmic."""

MOST_DECADES: Final = 1e6
"""Largest ratio of ordinates that such an axis shows."""


@dataclass(frozen=True, kw_only=True)
class Curve:
    """One curve of a chart.

    Attributes:
        label: Its name in the legend.
        style: Number of its colour and dash.
        x: Abscissae, increasing.
        y: Ordinates.
        low: Lower edge of a band around it, as long as ``x``; empty for none.
        high: Upper edge.
        open_at: Numbers of the points whose true ordinate is greater than drawn.
        doubtful_at: Numbers of the points that are not monotone boundaries.
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
class LineChart:
    """Content of one chart.

    Attributes:
        x_label: Quantity that is varied.
        y_label: Quantity drawn.
        curves: One for each variant.
        limit: Ordinate of a limit, if there is one.
        limit_label: Its name in the legend.
        least: An ordinate that is in view whatever the curves are, if there is one.
        points: Whether the curves are points without order, drawn without a line between them.
    """

    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    limit: float | None = None
    limit_label: str = ""
    least: float | None = None
    points: bool = False

    @property
    def description(self) -> str:
        """Content in words: the ends of every curve."""
        ends = "; ".join(
            f"{curve.label} from {number(curve.y[0])} at {number(curve.x[0])} to {number(curve.y[-1])} at "
            f"{number(curve.x[-1])}"
            for curve in self.curves
            if curve.x and not self.points
        )
        return f"{self.y_label} over {self.x_label}" + (f": {ends}." if ends else ".")


def line_chart_picture(charts: Sequence[LineChart], *, columns: int, title: str, description: str) -> str:
    """Return charts as one SVG, in rows of ``columns``."""
    rows = -(-len(charts) // columns)
    across = min(columns, len(charts))

    def draw(figure: Figure) -> None:
        for index, chart in enumerate(charts, start=1):
            draw_chart(figure.add_subplot(rows, across, index), chart)

    return svg_text(draw, width=WIDTH * across, height=HEIGHT * rows, title=title, description=description)


def draw_chart(axes: Axes, chart: LineChart) -> None:
    """Draw one chart; every curve has its place in the legend."""
    rings = range(len(chart.curves) - 1, -1, -1)
    for ring, curve in zip(rings, chart.curves, strict=True):
        if chart.points:
            _draw_points(axes, curve)
        else:
            _draw_curve(axes, curve, LEAST_MARK + RING * ring)
    abscissae = [x for curve in chart.curves for x in curve.x]
    if abscissae and chart.limit is not None:
        ends = min(abscissae), max(abscissae)
        axes.plot(ends, (chart.limit,) * 2, color=ZERO_COLOUR, linestyle=DASHES["dotted"], label=chart.limit_label)
    if abscissae and chart.least is not None:
        axes.update_datalim([(abscissae[0], chart.least)])
    axes.margins(x=0.04)
    axes.set(xlabel=chart.x_label, ylabel=chart.y_label)
    linear_up_to = _linear_up_to(chart)
    if linear_up_to is not None:
        axes.set_yscale("symlog", linthresh=linear_up_to, linscale=0.5)
        axes.set_ylabel(f"{chart.y_label} (log on either side of 0)")
    add_legend(axes, columns=LEGEND_COLUMNS)


def _linear_up_to(chart: LineChart) -> float | None:
    """Return the ordinate below which a symmetric logarithmic axis is linear; ``None``: a linear axis shows all."""
    if chart.limit != 0.0:
        return None
    sizes = [abs(y) for curve in chart.curves for y in (*curve.y, *curve.low, *curve.high) if y != 0.0]
    if not sizes or max(sizes) <= MOST_LINEAR * min(sizes):
        return None
    return max(min(sizes), max(sizes) / MOST_DECADES)


def _draw_points(axes: Axes, curve: Curve) -> None:
    colour, _ = line_style(curve.style)
    axes.plot(curve.x, curve.y, "o", color=colour, alpha=0.5, markersize=3, markeredgewidth=0, label=curve.label)


def _draw_curve(axes: Axes, curve: Curve, mark: float) -> None:
    """Draw line, band and points: hollow where the true ordinate is greater, square where it is doubtful."""
    colour, dash = line_style(curve.style)
    if curve.low:
        axes.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=BAND_ALPHA, linewidth=0.0)
    axes.plot(curve.x, curve.y, color=colour, linestyle=DASHES[dash], label=curve.label)
    for k, (x, y) in enumerate(zip(curve.x, curve.y, strict=True)):
        axes.plot(
            x,
            y,
            marker="s" if k in curve.doubtful_at else "o",
            markersize=mark,
            color=PAPER if k in curve.open_at else colour,
            markeredgecolor=colour,
        )
