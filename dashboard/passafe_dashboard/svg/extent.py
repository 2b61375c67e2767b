"""Where a chart's axes begin and end, and where their ticks stand."""

from collections.abc import Sequence
from math import ceil, floor, isfinite, log10
from typing import Final, Literal, NamedTuple

import numpy as np
from bokeh.models import Circle, ColumnDataSource, DataRange1d, FixedTicker
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure
from numpy.typing import NDArray

from passafe_dashboard.errors import UndrawableError
from passafe_dashboard.svg.marks import constant

Axis = Literal["x", "y"]

TICKS_WANTED: Final = 6
DEFAULT_PADDING: Final = 0.1
ROUNDING: Final = 1e-9
"""A tick that rounding puts so far outside its axis, in steps, is still drawn: 0.6 / 0.2 is less than 3."""


class Extent(NamedTuple):
    """An interval of data."""

    low: float
    high: float

    @property
    def span(self) -> float:
        """Its length."""
        return self.high - self.low

    def stretched(self, span: float) -> "Extent":
        """Interval of length ``span`` with the same middle."""
        middle = (self.low + self.high) / 2
        return Extent(middle - span / 2, middle + span / 2)


class Tick(NamedTuple):
    """A tick of an axis."""

    place: float
    text: str


def column(renderer: "GlyphRenderer[Circle]", axis: Axis) -> NDArray[np.float64]:
    """Data of a glyph along one axis."""
    source = renderer.data_source
    if not isinstance(source, ColumnDataSource):
        raise UndrawableError(type(source).__name__, ("ColumnDataSource",))
    return np.asarray(source.data[getattr(renderer.glyph, axis)], dtype=np.float64)


def extent_of(chart: figure, axis: Axis) -> Extent:
    """Interval that a chart shows along one axis: its range's, or one that holds all data of its range."""
    shown = chart.x_range if axis == "x" else chart.y_range
    if isinstance(shown, DataRange1d):
        named = shown.renderers
        chosen = named if isinstance(named, list) and named else chart.renderers
        padding = shown.range_padding if isinstance(shown.range_padding, float) else DEFAULT_PADDING
        data = _extent_of_data([part for part in chosen if isinstance(part, GlyphRenderer)], axis)
        least = shown.min_interval if isinstance(shown.min_interval, float) else 0.0
        return data.stretched(max(least, data.span * (1 + padding)))
    raise UndrawableError(type(shown).__name__, ("DataRange1d",))


def _extent_of_data(renderers: Sequence["GlyphRenderer[Circle]"], axis: Axis) -> Extent:
    low, high = [], []
    for renderer in renderers:
        values = column(renderer, axis)
        values = values[np.isfinite(values)]
        if values.size:
            radius = float(constant(renderer.glyph, "radius")) if isinstance(renderer.glyph, Circle) else 0.0
            low.append(values.min() - radius)
            high.append(values.max() + radius)
    if not low:
        return Extent(0.0, 1.0)
    found = Extent(float(min(low)), float(max(high)))
    return found if found.span > 0 else found.stretched(1.0)


def same_scale(x: Extent, y: Extent, width: float, height: float) -> tuple[Extent, Extent]:
    """Stretch one of two extents, so that a unit has the same length along both sides of a frame."""
    per_unit = min(width / x.span, height / y.span)
    return x.stretched(width / per_unit), y.stretched(height / per_unit)


def ticks_of(chart: figure, axis: Axis, extent: Extent) -> list[Tick]:
    """Ticks within an extent: the axis' own if it has fixed ones, else round numbers."""
    model = chart.xaxis[0] if axis == "x" else chart.yaxis[0]
    if isinstance(model.ticker, FixedTicker):
        texts = model.major_label_overrides
        places = [float(place) for place in model.ticker.ticks]
        return [Tick(place, str(texts[place])) for place in places if extent.low <= place <= extent.high]
    return round_ticks(extent)


def round_ticks(extent: Extent) -> list[Tick]:
    """Multiples of 1, 2 or 5 times a power of ten, about ``TICKS_WANTED`` of them."""
    if not (isfinite(extent.span) and extent.span > 0):
        return []
    rough = extent.span / TICKS_WANTED
    power = 10.0 ** floor(log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough)
    first, last = extent.low / step - ROUNDING, extent.high / step + ROUNDING
    numbers = range(ceil(first), floor(last) + 1)
    decimals = max(0, -floor(log10(step)))
    return [Tick(k * step, f"{k * step:.{decimals}f}".replace("-", "−") if k else "0") for k in numbers]
