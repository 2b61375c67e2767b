"""Draw the regions that the robot must not enter, and where they were over a run if they move."""

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from passafe_services.scenarios.barrier_kinds.motion import FloatArray
from passafe_services.scenarios.barrier_kinds.outline import Outline

from passafe_dashboard.palette import UNSAFE_COLOUR
from passafe_dashboard.run_series import RunSeries

UNSAFE_ALPHA: Final = 0.18
EARLIER_ALPHA: Final = 0.05
EARLIER: Final = 7
"""Earlier places of a moving outline that are drawn over a whole run."""

PATH_POINTS: Final = 200


def draw_keep_out(axes: Axes, series: RunSeries) -> list[Patch]:
    """Draw every region at the end of a run and, if it moves, its path and earlier places; return legend entries.

    Only a border that closes extends the view.
    """
    # Once where a barrier holds for several points, in the order of the scenario.
    outlines = list(dict.fromkeys(barrier.outline for barrier in series.barriers if barrier.outline is not None))
    for outline in outlines:
        if outline.motion is not None:
            _draw_path(axes, outline, series.times_s[0], series.times_s[-1])
        _draw_region(axes, outline, outline.displacements_m(series.times_s[-1:])[:, 0], earlier=False)
    entries = []
    if outlines:
        entries.append(_entry("keep out", earlier=False))
    if any(outline.motion is not None for outline in outlines):
        entries.append(_entry("keep out, earlier", earlier=True))
    return entries


def _draw_path(axes: Axes, outline: Outline, begin_s: float, end_s: float) -> None:
    for moved in outline.displacements_m(np.linspace(begin_s, end_s, EARLIER, endpoint=False)).T:
        _draw_region(axes, outline, moved, earlier=True)
    displacements = outline.displacements_m(np.linspace(begin_s, end_s, PATH_POINTS))
    path = np.array(outline.reference)[:, None] + displacements
    axes.add_artist(Line2D(*path, color=UNSAFE_COLOUR, linestyle="dotted", linewidth=1.2))


def _draw_region(axes: Axes, outline: Outline, moved: FloatArray, *, earlier: bool) -> None:
    """Draw an outline displaced by ``moved``, shape (2,), m."""
    if outline.is_bounded or not earlier:  # unbounded fills would cover one another
        corners = np.array(outline.unsafe) + moved
        alpha = EARLIER_ALPHA if earlier else UNSAFE_ALPHA
        axes.add_artist(Polygon(corners, color=UNSAFE_COLOUR, alpha=alpha, linewidth=0.0))
    edge = Line2D(
        *(np.array(outline.border) + moved).T,
        color=UNSAFE_COLOUR,
        linewidth=0.8 if earlier else 1.8,
        linestyle="dashed" if earlier else "solid",
    )
    if outline.is_closed:
        axes.add_line(edge)
    else:
        axes.add_artist(edge)


def _entry(label: str, *, earlier: bool) -> Patch:
    return Patch(
        label=label,
        facecolor=(UNSAFE_COLOUR, EARLIER_ALPHA if earlier else UNSAFE_ALPHA),
        edgecolor=UNSAFE_COLOUR,
        linestyle="dashed" if earlier else "solid",
        linewidth=0.8 if earlier else 1.8,
    )
