"""A whole chart as SVG: frame, grid, axes, data, legend."""

from collections.abc import Sequence
from typing import Final, NamedTuple
from xml.sax.saxutils import escape

from bokeh.models import Line, Scatter
from bokeh.models.annotations import Legend, LegendItem
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

from dashboard.errors import UndrawableError
from dashboard.palette import INK, PAPER
from dashboard.svg.extent import Extent, Tick, column, extent_of, same_scale, ticks_of
from dashboard.svg.marks import DRAWABLE, Scale, constant, draw, element, marker, stroke

LEFT, RIGHT, TOP, BOTTOM = 58.0, 12.0, 30.0, 44.0
"""Room around a chart's frame."""

GRID: Final = "#e0e0e0"
FONT: Final = "font-family:sans-serif;font-size:12px"
LETTER: Final = 6.2
"""About the width of a letter of ``FONT``."""


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
    width, height = placed.width - LEFT - RIGHT, placed.height - TOP - BOTTOM
    x, y = extent_of(chart, "x"), extent_of(chart, "y")
    if chart.match_aspect:
        x, y = same_scale(x, y, width, height)
    scale = Scale(
        x=lambda value: LEFT + (value - x.low) / x.span * width,
        y=lambda value: TOP + (y.high - value) / y.span * height,
        per_unit=width / x.span,
    )
    frame: dict[str, object] = {"x": LEFT, "y": TOP, "width": width, "height": height}
    return (
        element("clipPath", element("rect", **frame), id=clip)
        + _grid(ticks_of(chart, "x", x), ticks_of(chart, "y", y), scale, x, y)
        + element("g", _data(chart, scale), clip_path=f"url(#{clip})")
        + element("rect", **frame, fill="none", stroke=INK)
        + _labels(chart, width, height)
        + _legend(chart, LEFT + width)
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


def _labels(chart: figure, width: float, height: float) -> str:
    x_label = escape(str(chart.xaxis[0].axis_label))
    y_label = escape(str(chart.yaxis[0].axis_label))
    x, y = LEFT + width / 2, TOP + height / 2
    return element("text", x_label, x=x, y=TOP + height + 36, text_anchor="middle", fill=INK) + element(
        "text", y_label, text_anchor="middle", fill=INK, transform=f"translate(14 {y:.1f}) rotate(-90)"
    )


def _legend(chart: figure, right: float) -> str:
    """Entries above the frame, the last one at its right end."""
    parts = []
    legends = [part for part in chart.above if isinstance(part, Legend)]
    entries = [item for legend in legends for item in legend.items if isinstance(item, LegendItem)]
    for item in reversed(entries):
        text = str(constant(item, "label"))
        right -= LETTER * len(text)
        parts.append(element("text", escape(text), x=right, y=TOP - 10, fill=INK))
        glyph = item.renderers[0].glyph
        if isinstance(glyph, Line):
            y = TOP - 14
            parts.append(element("line", x1=right - 26, x2=right - 6, y1=y, y2=y, **stroke(glyph)))
        elif isinstance(glyph, Scatter):
            parts.append(marker(glyph, right - 14, TOP - 14))
        else:
            raise UndrawableError(f"legend entry with {type(glyph).__name__}", ("Line", "Scatter"))
        right -= 42
    return "".join(parts)
