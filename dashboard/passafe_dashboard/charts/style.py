"""Style every chart alike: frame, axes with units, legend, colours."""

from collections.abc import Sequence
from math import nan
from typing import Final

from bokeh.models import ColumnDataSource, DataRange1d, Line, Range
from bokeh.models.annotations import Legend, LegendItem
from bokeh.models.glyph import Glyph
from bokeh.plotting import figure

from passafe_dashboard.palette import INK, ZERO_COLOUR, line_style

TOOLS: Final = "pan,box_zoom,wheel_zoom,reset,save"
LEGEND_ROW_PX: Final = 26


def plain_chart(
    *,
    name: str,
    x_label: str,
    y_label: str,
    height: int,
    x_range: Range | None = None,
    match_aspect: bool = False,
) -> figure:
    """Return an empty chart in the dashboard's style; height in pixels, labels with units."""
    chart = figure(
        name=name,
        height=height,
        sizing_mode="stretch_width",
        tools=TOOLS,
        x_axis_label=x_label,
        y_axis_label=y_label,
        x_range=DataRange1d() if x_range is None else x_range,
        match_aspect=match_aspect,
        min_border_right=16,
    )
    chart.toolbar.logo = None
    chart.toolbar.autohide = True
    for axis in chart.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = INK
        axis.major_label_text_color = INK
    return chart


def styled_line(x: str, y: str, style: int) -> Line:
    """Return a line through columns ``x`` and ``y``, number ``style`` of its chart."""
    colour, dash = line_style(style)
    return Line(x=x, y=y, line_color=colour, line_dash=dash, line_width=2)


def zero_line(x: str, y: str) -> Line:
    """Return a line that marks a limit."""
    return Line(x=x, y=y, line_color=ZERO_COLOUR, line_width=1.2)


def key(chart: figure, label: str, glyph: Glyph) -> LegendItem:
    """Return a legend entry that shows the style of a glyph with x and y.

    The entry has a copy of the glyph without data: otherwise BokehJS would rebuild the legend with every streamed
    batch, and it would flicker.
    """
    nothing = ColumnDataSource({"x": [nan], "y": [nan]})
    return LegendItem(label=label, renderers=[chart.add_glyph(nothing, glyph.clone(x="x", y="y"))])


def add_legend(chart: figure, items: Sequence[LegendItem], *, columns: int = 3) -> None:
    """Put the legend above the plot, where it covers no data, in rows of ``columns`` entries.

    Every row after the first makes the chart taller, so the plot keeps its height.
    """
    chart.height = (chart.height or 0) + LEGEND_ROW_PX * ((len(items) - 1) // columns)
    legend = Legend(
        items=list(items),
        orientation="horizontal",
        ncols=min(columns, len(items)),
        background_fill_alpha=0.0,
        border_line_color=None,
        spacing=14,
        label_text_color=INK,
        label_text_font_size="9pt",
        location="right",
    )
    chart.add_layout(legend, "above")
