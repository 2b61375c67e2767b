"""Make charts over plant time: lines, the zero line, axis labels with units."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from bokeh.models import ColumnDataSource, DataRange1d, FixedTicker, HoverTool, Range
from bokeh.models.annotations import LegendItem
from bokeh.models.text import BaseText
from bokeh.plotting import figure

from passafe_dashboard.charts.style import add_legend, key, plain_chart, styled_line, zero_line
from passafe_dashboard.columns import TIME, ZERO

TIME_LABEL: Final = "plant time (s)"


@dataclass(frozen=True, kw_only=True)
class Trace:
    """One line of a chart.

    Attributes:
        source: Table that holds it; its ``time_s`` is the abscissa.
        column: Column drawn.
        label: Its name in legend and hover text, with the symbol.
        style: Number of its colour and dash.
        shown: Column that the hover text shows when it is not the one drawn.
    """

    source: ColumnDataSource
    column: str
    label: str
    style: int
    shown: str | None = None


def live_range(window_s: float) -> DataRange1d:
    """Return a time range that follows the newest sample."""
    return DataRange1d(follow="end", follow_interval=window_s, range_padding=0.0, default_span=window_s)


def time_chart(
    traces: Sequence[Trace],
    *,
    name: str,
    y_label: str,
    x_range: Range,
    least_span: float,
    height: int = 220,
    zero_label: str | None = None,
    y_ticks: dict[float, str] | None = None,
) -> figure:
    """Return a chart of lines over time, with the zero line.

    Args:
        traces: At least one.
        name: Unique name of the chart in its document.
        y_label: Quantity and unit.
        x_range: Time range, which charts of one page share.
        least_span: Least interval of the vertical axis, so that rounding errors do not fill the chart.
        height: Height in pixels.
        zero_label: Name of the zero line in the legend; no entry if ``None``.
        y_ticks: Place and text of each tick of the vertical axis, for an axis that is not linear.
    """
    chart = plain_chart(name=name, x_label=TIME_LABEL, y_label=y_label, x_range=x_range, height=height)
    chart.y_range = DataRange1d(min_interval=least_span)
    zero = zero_line(TIME, ZERO)
    chart.add_glyph(traces[0].source, zero)
    items = [] if zero_label is None else [key(chart, zero_label, zero)]
    items += [_add_trace(chart, trace) for trace in traces]
    add_legend(chart, items)
    if y_ticks is not None:
        chart.yaxis.ticker = FixedTicker(ticks=list(y_ticks))
        texts: dict[float | str, str | BaseText] = {  # noqa: C416 - dict() would keep the narrower types
            place: text for place, text in y_ticks.items()
        }
        chart.yaxis.major_label_overrides = texts
    return chart


def _add_trace(chart: figure, trace: Trace) -> LegendItem:
    """Draw a trace with hover text, and return its legend entry."""
    glyph = styled_line(TIME, trace.column, trace.style)
    line = chart.add_glyph(trace.source, glyph)
    shown = trace.shown or trace.column
    chart.add_tools(
        HoverTool(
            renderers=[line],
            tooltips=[(trace.label, f"@{shown}{{0.0000}}"), ("at", f"@{TIME}{{0.000}} s")],
            mode="vline",
            line_policy="nearest",
            visible=False,
        )
    )
    return key(chart, trace.label, glyph)
