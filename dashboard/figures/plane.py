"""The robot in its plane: where it was, where it is, and where it must not be."""

from math import hypot
from typing import Final

from bokeh.models import Circle, ColumnDataSource, DataRange1d, Line, Model, Patch, Scatter
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

from dashboard.columns import P1, P2
from dashboard.figures.style import add_legend, key, plain_figure
from dashboard.obstacles import Disk, HalfPlane, Obstacle, Undrawn
from dashboard.palette import INK, PAPER, TRAIL_COLOUR, UNSAFE_COLOUR

PLANE_DIMENSIONS: Final = 2
UNSAFE_ALPHA: Final = 0.18
WALL_EXTENT_M: Final = 100.0
"""How far a half-plane is drawn along and behind its line; the chart shows only what is near the robot."""


def plane_figure(
    obstacles: tuple[Obstacle, ...],
    *,
    trail: ColumnDataSource,
    robot: ColumnDataSource,
    start: tuple[float, float],
    height: int = 560,
) -> figure:
    """Obstacles, trail and robot with equal scales on both axes; obstacles outside the plane are not drawn.

    Args:
        obstacles: Shapes in the plane, m.
        trail: Columns ``p1_m`` and ``p2_m``, in order of time.
        robot: The same columns with one row, the newest position.
        start: Where the run begins, m.
        height: Height in pixels.
    """
    chart = plain_figure(
        name="plane",
        x_label="position p₁ (m)",
        y_label="position p₂ (m)",
        height=height,
        match_aspect=True,
    )
    shapes = [shape for obstacle in obstacles if (shape := _draw(chart, obstacle)) is not None]
    line = Line(x=P1, y=P2, line_color=TRAIL_COLOUR, line_width=2)
    begin = Scatter(x=P1, y=P2, marker="square", size=9, fill_color=PAPER, line_color=INK)
    dot = Scatter(x=P1, y=P2, marker="circle", size=13, fill_color=TRAIL_COLOUR, line_color=PAPER)
    drawn: list[Model] = [
        chart.add_glyph(trail, line),
        chart.add_glyph(ColumnDataSource({P1: [start[0]], P2: [start[1]]}), begin),
        chart.add_glyph(robot, dot),
    ]
    items = [key(chart, "trail", line), key(chart, "start", begin), key(chart, "robot", dot)]
    if shapes:
        items.insert(0, key(chart, "keep out", _unsafe_sample()))
    add_legend(chart, items, columns=4)
    drawn += [shape for shape in shapes if isinstance(shape.glyph, Circle)]
    chart.x_range = DataRange1d(renderers=drawn, range_padding=0.12)
    chart.y_range = DataRange1d(renderers=drawn, range_padding=0.12)
    return chart


def _draw(chart: figure, obstacle: Obstacle) -> "GlyphRenderer[Circle | Patch] | None":
    glyph: Circle | Patch
    if isinstance(obstacle, Disk):
        if len(obstacle.centre) != PLANE_DIMENSIONS:
            return None
        place = ColumnDataSource({P1: [obstacle.centre[0]], P2: [obstacle.centre[1]]})
        glyph = Circle(x=P1, y=P2, radius=obstacle.radius)
    elif isinstance(obstacle, Undrawn) or len(obstacle.normal) != PLANE_DIMENSIONS:
        return None
    else:
        corners = half_plane_corners(obstacle)
        place = ColumnDataSource({P1: [p1 for p1, _ in corners], P2: [p2 for _, p2 in corners]})
        glyph = Patch(x=P1, y=P2)
    glyph.update(fill_color=UNSAFE_COLOUR, fill_alpha=UNSAFE_ALPHA, line_color=UNSAFE_COLOUR, line_width=2)
    return chart.add_glyph(place, glyph)


def _unsafe_sample() -> Scatter:
    return Scatter(
        marker="square",
        size=12,
        fill_color=UNSAFE_COLOUR,
        fill_alpha=UNSAFE_ALPHA,
        line_color=UNSAFE_COLOUR,
        line_width=2,
    )


def half_plane_corners(plane: HalfPlane) -> tuple[tuple[float, float], ...]:
    """Corners of a rectangle that covers the forbidden side normalᵀp < offset near the origin, m.

    The first two lie on the line normalᵀp = offset, about its point nearest to the origin.
    """
    n1, n2 = plane.normal
    length = hypot(n1, n2)
    n1, n2 = n1 / length, n2 / length
    f1, f2 = n1 * plane.offset / length, n2 * plane.offset / length
    along, behind = WALL_EXTENT_M, WALL_EXTENT_M
    return (
        (f1 - n2 * along, f2 + n1 * along),
        (f1 + n2 * along, f2 - n1 * along),
        (f1 + n2 * along - n1 * behind, f2 - n1 * along - n2 * behind),
        (f1 - n2 * along - n1 * behind, f2 + n1 * along - n2 * behind),
    )
