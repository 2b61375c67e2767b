"""Draw the outlines of barriers in the plane, with their unsafe side filled, in tables that a page can move."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from bokeh.models import ColumnDataSource, Line, Model, Patch, Scatter
from bokeh.models.annotations import LegendItem
from bokeh.plotting import figure
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.outline import Outline, Polyline

from passafe_dashboard.charts.style import key
from passafe_dashboard.columns import P1, P2, moving_table
from passafe_dashboard.palette import UNSAFE_COLOUR

UNSAFE_ALPHA: Final = 0.18
BORDER: Final = "_border"
"""End of the name of the table with the border of a region without an end; see ``static/charts.js``."""

_FILL: Final[dict[str, object]] = {"fill_color": UNSAFE_COLOUR, "fill_alpha": UNSAFE_ALPHA}
_EDGE: Final[dict[str, object]] = {"line_color": UNSAFE_COLOUR, "line_width": 2}


class DrawnRegions(NamedTuple):
    """Regions that were drawn.

    Attributes:
        legend: Its legend entries.
        in_view: Renderers that the chart's ranges must hold.
    """

    legend: tuple[LegendItem, ...]
    in_view: tuple[Model, ...]


def draw_regions(chart: figure, barriers: Sequence[SingleBarrier]) -> DrawnRegions:
    """Draw every barrier with an outline before its motion, once where it holds for several points."""
    in_view: list[Model] = []
    outlines = distinct_outlines(barriers)
    for i, outline in outlines:
        motion = outline.motion
        drawn = _draw(chart, outline, name=None if motion is None else moving_table(i))
        # An outline that departs for good must not stretch the view; an unbounded one cannot be in view.
        if outline.is_closed and (motion is None or motion.returns):
            in_view.append(drawn)
    legend = (key(chart, "keep out", _sample()),) if outlines else ()
    return DrawnRegions(legend, tuple(in_view))


def distinct_outlines(barriers: Sequence[SingleBarrier]) -> list[tuple[int, Outline]]:
    """Return the outlines with the numbers of their barriers; of equal ones, the first."""
    seen: dict[Outline, int] = {}
    for i, barrier in enumerate(barriers):
        if barrier.outline is not None:
            seen.setdefault(barrier.outline, i)
    return [(i, outline) for outline, i in seen.items()]


def _draw(chart: figure, outline: Outline, *, name: str | None) -> Model:
    """Draw an outline; return the renderer whose data are its extent."""
    unsafe = Patch(x=P1, y=P2)
    # The polygon of an unbounded side has a cut and sides far away, which must not show.
    unsafe.update(**_FILL, **(_EDGE if outline.is_bounded else {"line_color": None}))
    drawn = chart.add_glyph(_places(outline.unsafe, name), unsafe)
    if outline.is_bounded:
        return drawn
    border = Line(x=P1, y=P2)
    border.update(**_EDGE)
    return chart.add_glyph(_places(outline.border, None if name is None else name + BORDER), border)


def _places(line: Polyline, name: str | None) -> ColumnDataSource:
    p1, p2 = zip(*line, strict=True)
    data = {P1: list(p1), P2: list(p2)}
    return ColumnDataSource(data) if name is None else ColumnDataSource(data, name=name)


def _sample() -> Scatter:
    sample = Scatter(marker="square", size=12)
    sample.update(**_FILL, **_EDGE)
    return sample
