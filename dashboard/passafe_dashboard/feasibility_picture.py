"""Draw a feasibility atlas: every cell in the colour of the first question that it answers with no."""

from typing import Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray
from passafe_services.tools.feasibility.atlas import LIMITATION, Atlas
from passafe_services.tools.feasibility.constraint_feasibility import Findings

from passafe_dashboard.palette import INK
from passafe_dashboard.pictures.svg_file import add_legend, svg_text

WIDTH: Final = 560.0
HEIGHT: Final = 582.0
"""Of the picture, points."""

Mask = NDArray[np.bool_]


class Category(NamedTuple):
    """Category of cells and its colour. Lightness differs between categories, so that grey print works too."""

    label: str
    colour: str


UNSAFE: Final = Category("h < 0", "#8A8A8A")
OUTSIDE: Final = Category("ψ < 0: not protected", "#DADADA")
CONFLICT: Final = Category("hard rows conflict", "#882255")
NOT_PASSIVE: Final = Category("not with passivity", "#E69F00")
KEPT: Final = Category("all can be kept", "#A8D3EE")


def categories_of(found: Findings) -> list[tuple[Category, Mask]]:
    """Return each category with its cells; every cell is in one category."""
    inside, hard, passive = found.inside, found.hard_kept, found.passive_kept
    unsafe = ~(found.h >= 0)
    return [
        (UNSAFE, unsafe),
        (OUTSIDE, ~inside & ~unsafe),
        (CONFLICT, inside & ~hard),
        (NOT_PASSIVE, inside & hard & ~passive),
        (KEPT, inside & passive),
    ]


def atlas_picture(atlas: Atlas, *, across: str, up: str, same_scale: bool) -> str:
    """Return the atlas as SVG.

    Args:
        atlas: The atlas.
        across: Label of the axis from left to right.
        up: Label of the axis from bottom to top.
        same_scale: Whether a unit shall have the same length along both axes.
    """
    return svg_text(
        lambda figure: draw_atlas(figure.add_subplot(), atlas, across=across, up=up, same_scale=same_scale),
        width=WIDTH,
        height=HEIGHT,
        title=f"Feasibility atlas of {atlas.scenario}",
        description=_description(atlas),
    )


def draw_atlas(axes: Axes, atlas: Atlas, *, across: str, up: str, same_scale: bool) -> None:
    """Draw the atlas; every answer has its place in the legend, whether it occurs or not.

    Arguments as for ``atlas_picture``.
    """
    answers, grid = categories_of(atlas.found), atlas.grid
    numbers = np.argmax([mask for _, mask in answers], axis=0)
    axes.imshow(
        numbers.reshape(grid.cells, grid.cells),
        cmap=ListedColormap([answer.colour for answer, _ in answers]),
        vmin=0,
        vmax=len(answers) - 1,
        extent=(grid.across.low, grid.across.high, grid.up.low, grid.up.high),
        origin="lower",
        interpolation="none",  # the file holds one pixel a cell
        aspect="equal" if same_scale else "auto",
    )
    axes.grid(visible=False)
    axes.set(xlabel=across, ylabel=up)
    entries = [Patch(facecolor=answer.colour, edgecolor=INK, label=answer.label) for answer, _ in answers]
    add_legend(axes, columns=3, before=entries)


def _description(atlas: Atlas) -> str:
    counts, grid = atlas.summary(None).slice, atlas.grid
    varied = grid.across.index, grid.up.index
    fixed = ", ".join(f"x{i} = {value:g}" for i, value in enumerate(grid.fixed) if i not in varied)
    at = f"{fixed}, " if fixed else ""
    return (
        f"At {at}plant time {atlas.plant_time_s:g} s: of {counts.states} cells {counts.inside} are in the set that "
        f"the rows protect; in {counts.hard} of these the hard rows can be kept, in {counts.passive} passivity "
        f"too. {LIMITATION}"
    )
