"""Glyphs of a chart as SVG elements."""

from collections.abc import Callable, Iterable
from math import isfinite
from typing import Any, Final, NamedTuple
from xml.sax.saxutils import quoteattr

from bokeh.core.property.vectorization import Field, Value
from bokeh.model import Model
from bokeh.models import Circle, Line, Patch, Scatter
from bokeh.models.glyph import Glyph

from passafe_dashboard.errors import UndrawableError

DRAWABLE: Final = ("Line", "Patch", "Circle", "Scatter with marker circle or square")


DASHES: Final = {"solid": (), "dashed": (6,), "dotted": (2, 4), "dotdash": (2, 4, 6, 4), "dashdot": (6, 4, 2, 4)}
"""Lengths of the dashes that Bokeh knows by name; glyphs whose outline may vary with the data keep the name."""


class Scale(NamedTuple):
    """From data to the picture's units.

    Attributes:
        x: Horizontal place of a datum.
        y: Vertical place, growing downwards.
        per_unit: Length of one datum unit along x.
    """

    x: Callable[[float], float]
    y: Callable[[float], float]
    per_unit: float


def element(name: str, text: str | None = None, /, **attributes: object) -> str:
    """An SVG element; ``_`` in an attribute's name stands for ``-``, numbers get two decimals."""
    parts = [name]
    for key, value in attributes.items():
        shown = f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)
        parts.append(f"{key.replace('_', '-')}={quoteattr(shown)}")
    opening = " ".join(parts)
    return f"<{opening}/>" if text is None else f"<{opening}>{text}</{name}>"


def constant(model: Model, name: str) -> Any:  # noqa: ANN401 - colours, lengths and words alike
    """Value of a property that is the same for all data.

    Raises:
        UndrawableError: It varies with the data.
    """
    value = getattr(model, name)
    if isinstance(value, Field):
        raise UndrawableError(f"{name} that varies with the data", ("constants",))
    return value.value if isinstance(value, Value) else value


def draw(glyph: Glyph, xs: Iterable[float], ys: Iterable[float], scale: Scale) -> str:
    """A glyph at data ``xs``, ``ys``.

    Raises:
        UndrawableError: The glyph is of a type not known here.
    """
    points = [
        (scale.x(float(x)), scale.y(float(y))) if isfinite(x) and isfinite(y) else None
        for x, y in zip(xs, ys, strict=True)
    ]
    if isinstance(glyph, Line):
        return element("path", d=_path(points), fill="none", **stroke(glyph))
    if isinstance(glyph, Patch):
        return element("path", d=_path(points) + "Z", **fill(glyph), **stroke(glyph))
    if isinstance(glyph, Circle):
        radius = float(constant(glyph, "radius")) * scale.per_unit
        return _each(points, lambda x, y: _disk(x, y, radius, glyph))
    if isinstance(glyph, Scatter):
        return _each(points, lambda x, y: marker(glyph, x, y))
    raise UndrawableError(type(glyph).__name__, DRAWABLE)


def marker(glyph: Scatter, x: float, y: float) -> str:
    """One marker of a scatter glyph at a place in the picture's units."""
    size = float(constant(glyph, "size"))
    shape = constant(glyph, "marker")
    if shape == "circle":
        return _disk(x, y, size / 2, glyph)
    if shape == "square":
        corner = {"x": x - size / 2, "y": y - size / 2}
        return element("rect", **corner, width=size, height=size, **fill(glyph), **stroke(glyph))
    raise UndrawableError(f"Scatter with marker {shape}", DRAWABLE)


def stroke(glyph: Glyph) -> dict[str, object]:
    """Attributes of a glyph's outline."""
    colour, width, dash = (constant(glyph, name) for name in ("line_color", "line_width", "line_dash"))
    if colour is None:
        return {"stroke": "none"}
    attributes: dict[str, object] = {"stroke": colour, "stroke_width": float(width)}
    lengths = DASHES[dash] if isinstance(dash, str) else dash
    if lengths:
        attributes["stroke_dasharray"] = " ".join(str(length) for length in lengths)
    return attributes


def fill(glyph: Glyph) -> dict[str, object]:
    """Attributes of a glyph's inside."""
    return {"fill": constant(glyph, "fill_color"), "fill_opacity": float(constant(glyph, "fill_alpha"))}


def _disk(x: float, y: float, radius: float, glyph: Glyph) -> str:
    return element("circle", cx=x, cy=y, r=radius, **fill(glyph), **stroke(glyph))


def _each(points: Iterable[tuple[float, float] | None], mark: Callable[[float, float], str]) -> str:
    return "".join(mark(*point) for point in points if point is not None)


def _path(points: Iterable[tuple[float, float] | None]) -> str:
    """Path through points; ``None`` interrupts it."""
    parts: list[str] = []
    pen_down = False
    for point in points:
        if point is not None:
            parts.append(f"{'L' if pen_down else 'M'}{point[0]:.2f} {point[1]:.2f}")
        pen_down = point is not None
    return "".join(parts)
