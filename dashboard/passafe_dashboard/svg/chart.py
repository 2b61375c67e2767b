"""A whole chart as SVG: frame, grid, axes, data, legend."""

from collections.abc import Sequence
from typing import Final, NamedTuple
from xml.sax.saxutils import escape

from bokeh.models import Line, Scatter
from bokeh.models.annotations import Legend, LegendItem
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

from passafe_dashboard.errors import UndrawableError
from passafe_dashboard.palette import INK, PAPER
from passafe_dashboard.svg.extent import Extent, Tick, column, extent_of, same_scale, ticks_of
from passafe_dashboard.svg.marks import DRAWABLE, Scale, constant, draw, element, marker, stroke

LEFT, RIGHT, TOP, BOTTOM = 58.0, 12.0, 30.0, 44.0
"""Room around a chart's frame."""

GRID: Final = "#e0e0e0"
FONT: Final = "font-family:sans-serif;font-size:12px"
LETTER: Final = 6.2
"""About the width of a letter of ``FONT``."""

SAMPLE: Final = 42.0
LEGEND_ROW: Final = 18.0
"""Width of a legend's sample with the room around it, height of a row."""


class Placed(NamedTuple):
    """A chart and its place in a picture."""

    chart: figure
    x: float
    y: float
    width: float
    height: float


def picture(charts: Sequence[Placed], *, width: float, height: float, title: str, description: str) -> str:
    """One SVG file of several charts.

    Args:
        charts: The charts and their places.
        width: Width of the picture.
        height: Its height.
        title: Short title for who cannot see it.
        description: What it shows, likewise.

    Raises:
        UndrawableError: A chart has a part that is not known here.
    """
    body = "".join(
        element("g", _chart(placed, f"frame{number}"), transform=f"translate({placed.x:g} {placed.y:g})")
        for number, placed in enumerate(charts)
    )
    content = (
        element("title", escape(title))
        + element("desc", escape(description))
        + element("rect", width=width, height=height, fill=PAPER)
        + body
    )
    return element(
        "svg",
        content,
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {width:g} {height:g}",
        width=width,
        height=height,
        role="img",
        style=FONT,
    )


def _chart(placed: Placed, clip: str) -> str:
    chart = placed.chart
    width = placed.width - LEFT - RIGHT
    rows = _legend_rows(chart, width)
    top = TOP + LEGEND_ROW * max(0, len(rows) - 1)
    height = placed.height - top - BOTTOM
    x, y = extent_of(chart, "x"), extent_of(chart, "y")
    if chart.match_aspect:
        x, y = same_scale(x, y, width, height)
    scale = Scale(
        x=lambda value: LEFT + (value - x.low) / x.span * width,
        y=lambda value: top + (y.high - value) / y.span * height,
        per_unit=width / x.span,
    )
    frame: dict[str, object] = {"x": LEFT, "y": top, "width": width, "height": height}
    return (
        element("clipPath", element("rect", **frame), id=clip)
        + _grid(ticks_of(chart, "x", x), ticks_of(chart, "y", y), scale, x, y)
        + element("g", _data(chart, scale), clip_path=f"url(#{clip})")
        + element("rect", **frame, fill="none", stroke=INK)
        + _labels(chart, width, top, height)
        + _legend(rows, LEFT + width, top - 10)
    )


def _data(chart: figure, scale: Scale) -> str:
    drawn = []
    for renderer in chart.renderers:
        if not isinstance(renderer, GlyphRenderer):
            raise UndrawableError(type(renderer).__name__, DRAWABLE)
        drawn.append(draw(renderer.glyph, column(renderer, "x"), column(renderer, "y"), scale))
    return "".join(drawn)


def _grid(x_ticks: Sequence[Tick], y_ticks: Sequence[Tick], scale: Scale, x: Extent, y: Extent) -> str:
    top, bottom = scale.y(y.high), scale.y(y.low)
    left, right = scale.x(x.low), scale.x(x.high)
    parts = []
    for tick in x_ticks:
        place = scale.x(tick.place)
        parts.append(element("line", x1=place, x2=place, y1=top, y2=bottom, stroke=GRID))
        parts.append(element("text", tick.text, x=place, y=bottom + 16, text_anchor="middle", fill=INK))
    for tick in y_ticks:
        place = scale.y(tick.place)
        parts.append(element("line", x1=left, x2=right, y1=place, y2=place, stroke=GRID))
        parts.append(element("text", tick.text, x=left - 6, y=place + 4, text_anchor="end", fill=INK))
    return "".join(parts)


def _labels(chart: figure, width: float, top: float, height: float) -> str:
    x_label = escape(str(chart.xaxis[0].axis_label))
    y_label = escape(str(chart.yaxis[0].axis_label))
    x, y = LEFT + width / 2, top + height / 2
    return element("text", x_label, x=x, y=top + height + 36, text_anchor="middle", fill=INK) + element(
        "text", y_label, text_anchor="middle", fill=INK, transform=f"translate(14 {y:.1f}) rotate(-90)"
    )


def _legend_rows(chart: figure, width: float) -> list[list[LegendItem]]:
    """Legend entries in as many rows as it takes."""
    rows: list[list[LegendItem]] = []
    left = 0.0
    legends = [part for part in chart.above if isinstance(part, Legend)]
    for item in (item for legend in legends for item in legend.items if isinstance(item, LegendItem)):
        needed = _entry_width(item)
        if needed > left:
            rows.append([])
            left = width
        rows[-1].append(item)
        left -= needed
    return rows


def _entry_width(item: LegendItem) -> float:
    return LETTER * len(str(constant(item, "label"))) + SAMPLE


def _legend(rows: Sequence[Sequence[LegendItem]], right: float, bottom: float) -> str:
    """Entries above the frame; each row ends at its right end, the last one is the lowest."""
    parts = []
    for number, row in enumerate(rows):
        y = bottom - LEGEND_ROW * (len(rows) - 1 - number)
        x = right
        for item in reversed(row):
            x -= _entry_width(item)
            parts.append(_sample(item, x + SAMPLE / 2, y - 4))
            text = escape(str(constant(item, "label")))
            parts.append(element("text", text, x=x + SAMPLE - 6, y=y, fill=INK))
    return "".join(parts)


def _sample(item: LegendItem, x: float, y: float) -> str:
    glyph = item.renderers[0].glyph
    if isinstance(glyph, Line):
        return element("line", x1=x - 10, x2=x + 10, y1=y, y2=y, **stroke(glyph))
    if isinstance(glyph, Scatter):
        return marker(glyph, x, y)
    raise UndrawableError(f"legend entry with {type(glyph).__name__}", ("Line", "Scatter"))
