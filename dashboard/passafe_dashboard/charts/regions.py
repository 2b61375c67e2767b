"""Draw the outlines of barriers in the plane, with their unsafe side filled; those that move, along their path."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource, Line, Model, Patch, Scatter
from bokeh.models.annotations import LegendItem
from bokeh.plotting import figure
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.motion import FloatArray
from passafe_services.scenarios.barrier_kinds.outline import Outline, Polyline

from passafe_dashboard.charts.style import key
from passafe_dashboard.columns import P1, P2, moving_table
from passafe_dashboard.palette import UNSAFE_COLOUR

UNSAFE_ALPHA: Final = 0.18
EARLIER_ALPHA: Final = 0.05
EARLIER: Final = 7
"""Earlier places of a moving outline that are drawn over a whole run."""

PATH_POINTS: Final = 200
BORDER: Final = "_border"
"""End of the name of the table with the border of a region without an end; see ``static/charts.js``."""


NOT_MOVED: Final = np.zeros(2)


class Drawing(NamedTuple):
    """Plant times at which moving outlines are drawn: once in named tables that a page moves, or over a whole run.

    Attributes:
        begin_s: Plant time of the begin of the run, s.
        end_s: Plant time of its end, at which a moving outline is drawn like one at rest.
        live: Whether a page moves it instead; then it is drawn before its motion.
    """

    begin_s: float = 0.0
    end_s: float = 0.0
    live: bool = False


LIVE: Final = Drawing(live=True)


class DrawnRegions(NamedTuple):
    """Regions that were drawn.

    Attributes:
        legend: Its legend entries.
        in_view: Renderers that the chart's ranges must hold.
    """

    legend: tuple[LegendItem, ...]
    in_view: tuple[Model, ...]


def draw_regions(chart: figure, barriers: Sequence[SingleBarrier], drawing: Drawing) -> DrawnRegions:
    """Draw every barrier with an outline, once where it holds for several points."""
    in_view: list[Model] = []
    outlines = distinct_outlines(barriers)
    for i, outline in outlines:
        motion = outline.motion
        if motion is None or drawing.live:
            now = _draw(chart, outline, NOT_MOVED, name=None if motion is None else moving_table(i))
        else:
            in_view += _draw_path(chart, outline, drawing)
            now = _draw(chart, outline, outline.displacements_m(np.array([drawing.end_s]))[:, 0])
        # An outline that departs for good must not stretch the view; an unbounded one cannot be in view.
        if outline.is_closed and not (drawing.live and motion is not None and not motion.returns):
            in_view.append(now)
    legend = []
    if outlines:
        legend.append(key(chart, "keep out", _sample(earlier=False)))
    if not drawing.live and any(outline.motion is not None for _, outline in outlines):
        legend.append(key(chart, "keep out, earlier", _sample(earlier=True)))
    return DrawnRegions(tuple(legend), tuple(in_view))


def distinct_outlines(barriers: Sequence[SingleBarrier]) -> list[tuple[int, Outline]]:
    """Return the outlines with the numbers of their barriers; of equal ones, the first."""
    seen: dict[Outline, int] = {}
    for i, barrier in enumerate(barriers):
        if barrier.outline is not None:
            seen.setdefault(barrier.outline, i)
    return [(i, outline) for outline, i in seen.items()]


def _draw_path(chart: figure, outline: Outline, drawing: Drawing) -> Iterator[Model]:
    """Draw the path of a moving outline and some earlier places; yield the renderers that must be in view."""
    earlier_s = np.linspace(drawing.begin_s, drawing.end_s, EARLIER, endpoint=False)
    for moved in outline.displacements_m(earlier_s).T:
        drawn = _draw(chart, outline, moved, earlier=True)
        if outline.is_closed:
            yield drawn
    times_s = np.linspace(drawing.begin_s, drawing.end_s, PATH_POINTS)
    path = np.array(outline.reference)[:, None] + outline.displacements_m(times_s)
    line = Line(x=P1, y=P2, line_color=UNSAFE_COLOUR, line_dash="dotted", line_width=1.5)
    chart.add_glyph(ColumnDataSource({P1: path[0].tolist(), P2: path[1].tolist()}), line)


def _draw(
    chart: figure, outline: Outline, moved: FloatArray, *, name: str | None = None, earlier: bool = False
) -> Model:
    """Draw an outline displaced by ``moved``, shape (2,), m; return the renderer whose data are its extent."""
    if outline.is_bounded or not earlier:  # unbounded fills would cover one another
        unsafe = Patch(x=P1, y=P2)
        # The polygon of an unbounded side has a cut and sides far away, which must not show.
        unsafe.update(
            **_fill(earlier=earlier), **(_edge(earlier=earlier) if outline.is_bounded else {"line_color": None})
        )
        drawn = chart.add_glyph(_places(outline.unsafe, moved, name), unsafe)
        if outline.is_bounded:
            return drawn
    border = Line(x=P1, y=P2)
    border.update(**_edge(earlier=earlier))
    return chart.add_glyph(_places(outline.border, moved, None if name is None else name + BORDER), border)


def _places(line: Polyline, moved: FloatArray, name: str | None) -> ColumnDataSource:
    p1, p2 = (np.array(line) + moved).T.tolist()
    data = {P1: p1, P2: p2}
    return ColumnDataSource(data) if name is None else ColumnDataSource(data, name=name)


def _fill(*, earlier: bool) -> dict[str, object]:
    return {"fill_color": UNSAFE_COLOUR, "fill_alpha": EARLIER_ALPHA if earlier else UNSAFE_ALPHA}


def _edge(*, earlier: bool) -> dict[str, object]:
    if earlier:
        return {"line_color": UNSAFE_COLOUR, "line_width": 1, "line_dash": "dashed"}
    return {"line_color": UNSAFE_COLOUR, "line_width": 2}


def _sample(*, earlier: bool) -> Scatter:
    sample = Scatter(marker="square", size=12)
    sample.update(**_fill(earlier=earlier), **_edge(earlier=earlier))
    return sample
