"""The feasibility atlas as a picture: every cell in the colour of the first question that it answers with no."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d, Model, Patch, Scatter
from bokeh.plotting import figure
from numpy.typing import NDArray
from passafe_services.tools.feasibility.atlas import WHAT_IT_SAYS, Atlas
from passafe_services.tools.feasibility.constraint_feasibility import Findings
from passafe_services.tools.feasibility.grid import Grid

from passafe_dashboard.charts.style import add_legend, key, plain_figure
from passafe_dashboard.palette import INK
from passafe_dashboard.svg.chart import Placed, picture

WIDTH, HEIGHT = 560.0, 582.0
"""Of the picture, so that its frame is a square."""

SEAM: Final = 0.6
"""Width of the outline that closes the hairlines between neighbouring rows of cells."""

X, Y = "across", "up"

Mask = NDArray[np.bool_]


class Region(NamedTuple):
    """One answer and its colour. Lightness differs from one to the next, so that grey print works too."""

    label: str
    colour: str


UNSAFE: Final = Region("h < 0", "#8A8A8A")
OUTSIDE: Final = Region("ψ < 0: not protected", "#DADADA")
CONFLICT: Final = Region("hard rows conflict", "#882255")
NOT_PASSIVE: Final = Region("not with passivity", "#E69F00")
KEPT: Final = Region("all can be kept", "#A8D3EE")


def regions_of(found: Findings) -> list[tuple[Region, Mask]]:
    """Return each region with the cells that belong to it; every cell belongs to one."""
    inside, hard, passive = found.inside, found.hard_kept, found.passive_kept
    unsafe = ~(found.h >= 0)
    return [
        (UNSAFE, unsafe),
        (OUTSIDE, ~inside & ~unsafe),
        (CONFLICT, inside & ~hard),
        (NOT_PASSIVE, inside & hard & ~passive),
        (KEPT, inside & passive),
    ]


def atlas_figure(atlas: Atlas, *, across: str, up: str, same_scale: bool) -> figure:
    """Return the map as a chart; every answer has its place in the legend, whether it occurs or not.

    Args:
        atlas: The map.
        across: Label of the axis from left to right.
        up: Label of the axis from bottom to top.
        same_scale: Whether a unit shall have the same length along both axes.
    """
    chart = plain_figure(name="atlas", x_label=across, y_label=up, height=int(HEIGHT), match_aspect=same_scale)
    cells = atlas.grid.cells
    drawn: list[Model] = []
    items = []
    for region, mask in regions_of(atlas.found):
        xs, ys = outline(mask.reshape(cells, cells), atlas.grid)
        glyph = Patch(x=X, y=Y, fill_color=region.colour, line_color=region.colour, line_width=SEAM)
        drawn.append(chart.add_glyph(ColumnDataSource({X: xs, Y: ys}), glyph))
        sample = Scatter(marker="square", size=12, fill_color=region.colour, line_color=INK)
        items.append(key(chart, region.label, sample))
    add_legend(chart, items, columns=3)
    chart.x_range = DataRange1d(renderers=drawn, range_padding=0.0)
    chart.y_range = DataRange1d(renderers=drawn, range_padding=0.0)
    return chart


def outline(mask: Mask, grid: Grid) -> tuple[list[float], list[float]]:
    """Return corners of rectangles that cover the cells of a mask, one for each run in a row, NaN between them.

    Args:
        mask: Which cells, shape (cells, cells), the lowest row first.
        grid: Where they are.
    """
    x_edges, y_edges = grid.edges(grid.across), grid.edges(grid.up)
    xs: list[float] = []
    ys: list[float] = []
    for row, y_low, y_high in zip(mask, y_edges, y_edges[1:], strict=False):
        for begin, end in _runs(row):
            left, right = float(x_edges[begin]), float(x_edges[end])
            xs += [left, right, right, left, left, np.nan]
            ys += [y_low, y_low, y_high, y_high, y_low, np.nan]
    return xs, [float(y) for y in ys]


def atlas_picture(atlas: Atlas, *, across: str, up: str, same_scale: bool) -> str:
    """Return the map as SVG; arguments as for ``atlas_figure``."""
    chart = atlas_figure(atlas, across=across, up=up, same_scale=same_scale)
    counts = atlas.summary(None).slice
    fixed = ", ".join(f"x{i} = {value:g}" for i, value in enumerate(atlas.grid.fixed) if i not in _varied(atlas.grid))
    at = f"{fixed}, " if fixed else ""
    return picture(
        [Placed(chart, 0, 0, WIDTH, HEIGHT)],
        width=WIDTH,
        height=HEIGHT,
        title=f"Feasibility atlas of {atlas.scenario}",
        description=(
            f"At {at}plant time {atlas.plant_time_s:g} s: of {counts.states} cells {counts.inside} are in the set that "
            f"the rows protect; in {counts.hard} of these the hard rows can be kept, in {counts.passive} passivity "
            f"too. {WHAT_IT_SAYS}"
        ),
    )


def _varied(grid: Grid) -> Sequence[int]:
    return grid.across.index, grid.up.index


def _runs(row: Mask) -> list[tuple[int, int]]:
    """Return where cells of one row that belong to the mask begin and end."""
    padded = np.concatenate(([0], row.astype(np.int8), [0]))
    steps = np.diff(padded)
    return list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))
