"""Obstacles in the plane: filled where the robot must not be, and again wherever they move to."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from bokeh.models import Circle, ColumnDataSource, Line, Model, Patch, Scatter
from bokeh.models.annotations import LegendItem
from bokeh.plotting import figure
from passafe_services.scenarios.barrier_schema import Travel

from passafe_dashboard.charts.style import key
from passafe_dashboard.columns import P1, P2, moving_table
from passafe_dashboard.motion import displacement
from passafe_dashboard.obstacles import Disk, HalfPlane, Obstacle, Region
from passafe_dashboard.outlines import border, reference, shifted, unsafe_side
from passafe_dashboard.palette import UNSAFE_COLOUR

UNSAFE_ALPHA: Final = 0.18
EARLIER_ALPHA: Final = 0.05
EARLIER: Final = 7
"""How often what moves is drawn where it was, over a whole run."""

WAY_POINTS: Final = 200
BORDER: Final = "_border"
"""End of the name of the table with the border of a region without an end; see ``static/charts.js``."""


class Drawing(NamedTuple):
    """When to draw what moves: at one time in named tables that a page moves, or over a whole run.

    Attributes:
        begin_s: Plant time of the run's begin, s.
        end_s: Of its end, at which what moves is drawn as what stands still is.
        live: Whether a page moves it instead; then it is drawn where the scenario has it before it has moved.
    """

    begin_s: float = 0.0
    end_s: float = 0.0
    live: bool = False


LIVE: Final = Drawing(live=True)


class DrawnRegions(NamedTuple):
    """What was drawn.

    Attributes:
        legend: Its legend entries.
        in_view: Renderers that the chart's ranges must hold.
    """

    legend: tuple[LegendItem, ...]
    in_view: tuple[Model, ...]


def draw_regions(chart: figure, obstacles: Sequence[Obstacle], drawing: Drawing) -> DrawnRegions:
    """Draw every obstacle that is a place, once where it holds for several points."""
    in_view: list[Model] = []
    moved = False
    regions = _distinct(obstacles)
    for i, region in regions:
        if region.motion is None or drawing.live:
            by, name = (0.0, 0.0), moving_table(i) if region.motion is not None else None
        else:
            moved = True
            in_view += _draw_way(chart, region, drawing)
            by, name = displacement(region.motion, drawing.end_s), None
        now = _draw(chart, region, by, name=name)
        # What goes away for good must not take the view along; a line has no end to be in view.
        if not isinstance(region, HalfPlane) and not (drawing.live and isinstance(region.motion, Travel)):
            in_view.append(now)
    legend = []
    if regions:
        legend.append(key(chart, "keep out", _sample(earlier=False)))
    if moved:
        legend.append(key(chart, "keep out, earlier", _sample(earlier=True)))
    return DrawnRegions(tuple(legend), tuple(in_view))


def _distinct(obstacles: Sequence[Obstacle]) -> list[tuple[int, Region]]:
    """Return the regions with their numbers; of those that are alike but for name and point, the first one."""
    seen: dict[Region, int] = {}
    for i, one in enumerate(obstacles):
        if isinstance(one, Region):
            seen.setdefault(replace(one, name="", first=0), i)
    return [(i, region) for region, i in seen.items()]


def _draw_way(chart: figure, region: Region, drawing: Drawing) -> Iterator[Model]:
    """Draw the way of what moves and where it was on it; yield what must be in view."""
    for t_s in np.linspace(drawing.begin_s, drawing.end_s, EARLIER, endpoint=False):
        drawn = _draw(chart, region, displacement(region.motion, float(t_s)), earlier=True)
        if not isinstance(region, HalfPlane):
            yield drawn
    times = np.linspace(drawing.begin_s, drawing.end_s, WAY_POINTS)
    way = [shifted((reference(region),), displacement(region.motion, float(t_s)))[0] for t_s in times]
    chart.add_glyph(_places(way), Line(x=P1, y=P2, line_color=UNSAFE_COLOUR, line_dash="dotted", line_width=1.5))


def _draw(
    chart: figure, region: Region, by: tuple[float, float], *, name: str | None = None, earlier: bool = False
) -> Model:
    """Draw a region moved by ``by``, m; return the renderer whose data are its extent."""
    if isinstance(region, Disk) and not region.keep_in:
        disk = Circle(x=P1, y=P2, radius=region.radius)
        disk.update(**_fill(earlier=earlier), **_edge(earlier=earlier))
        return chart.add_glyph(_places(shifted((reference(region),), by), name), disk)
    unbounded = isinstance(region, HalfPlane) or region.keep_in
    if not (unbounded and earlier):  # fills without an end would lie upon one another
        shut_off = Patch(x=P1, y=P2)
        # The polygon of what lies outside has a cut and sides far away, which must not show.
        shut_off.update(**_fill(earlier=earlier), **({"line_color": None} if unbounded else _edge(earlier=earlier)))
        drawn = chart.add_glyph(_places(shifted(unsafe_side(region), by), name), shut_off)
        if not unbounded:
            return drawn
    rim = Line(x=P1, y=P2)
    rim.update(**_edge(earlier=earlier))
    return chart.add_glyph(_places(shifted(border(region), by), None if name is None else name + BORDER), rim)


def _places(line: Sequence[tuple[float, float]], name: str | None = None) -> ColumnDataSource:
    data = {P1: [p1 for p1, _ in line], P2: [p2 for _, p2 in line]}
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
