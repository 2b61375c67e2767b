"""Draw runs over one another: their paths in the plane beside lowest barrier and power margin over aligned time."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from passafe_dashboard.decimation import kept_samples
from passafe_dashboard.palette import INK, PAPER, ZERO_COLOUR, line_style
from passafe_dashboard.pictures.keep_out import draw_keep_out
from passafe_dashboard.pictures.svg_file import DASHES, add_legend, svg_text
from passafe_dashboard.run_series import FloatArray, RunSeries

PLANE_SIDE: Final = 440.0
CHART_WIDTH: Final = 520.0
NOTE_HEIGHT: Final = 16.0
BINS: Final = 400
STYLES: Final = (0, 3, 5, 7)
"""Numbers of the styles of the runs, apart in colour and dash."""

ALIGNED_TIME: Final = "aligned time (s)"


class OverlaidRun(NamedTuple):
    """One run of an overlay.

    Attributes:
        name: Its name in the legend.
        series: Its signals.
        origin_s: Plant time that is drawn as zero, s.
    """

    name: str
    series: RunSeries
    origin_s: float


def overlay_picture(runs: Sequence[OverlaidRun], *, title: str, notes: Sequence[str] = ()) -> str:
    """Return the SVG of runs over one another.

    Args:
        runs: At least one.
        title: Its title for screen readers.
        notes: Lines below the charts.
    """
    in_plane = all(run.series.points for run in runs)

    def draw(figure: Figure) -> None:
        charts: list[Callable[[Axes], None]] = [
            lambda axes: _draw_over_time(axes, runs, _lowest, "lowest barrier h"),
            lambda axes: _draw_over_time(axes, runs, _power, "power margin (W)"),
        ]
        if in_plane:
            grid = figure.add_gridspec(len(charts), 2, width_ratios=(PLANE_SIDE, CHART_WIDTH))
            _draw_plane(figure.add_subplot(grid[:, 0]), runs)
        else:
            grid = figure.add_gridspec(len(charts), 1)
        for row, chart in enumerate(charts):
            chart(figure.add_subplot(grid[row, 1 if in_plane else 0]))
        if notes:
            figure.supxlabel("\n".join(notes), x=0.01, ha="left", fontsize=9, color=INK)

    lowest = "; ".join(f"{run.name}: lowest h {_least(_lowest(run.series)):.4g}" for run in runs)
    return svg_text(
        draw,
        width=CHART_WIDTH + (PLANE_SIDE if in_plane else 0.0),
        height=PLANE_SIDE + NOTE_HEIGHT * len(notes),
        title=title,
        description=". ".join([lowest, *notes]),
    )


def _lowest(series: RunSeries) -> FloatArray:
    return series.h.min(axis=0) if series.barriers else np.full(series.times_s.size, np.nan)


def _power(series: RunSeries) -> FloatArray:
    return series.power_margin_w


def _least(values: FloatArray) -> float:
    return float(np.nanmin(values)) if not np.isnan(values).all() else float("nan")


def _draw_plane(axes: Axes, runs: Sequence[OverlaidRun]) -> None:
    entries = draw_keep_out(axes, runs[0].series)
    for number, run in enumerate(runs):
        colour, dash = line_style(STYLES[number % len(STYLES)])
        for point in range(run.series.points):
            p1, p2 = run.series.position(point)
            kept = kept_samples([p1, p2], bins=BINS)
            label = run.name if point == 0 else "_"  # an underscore keeps it out of the legend
            axes.plot(p1[kept], p2[kept], color=colour, linestyle=DASHES[dash], label=label)
            axes.plot(p1[-1:], p2[-1:], "o", color=colour, markeredgecolor=PAPER, markersize=9)
    axes.set(xlabel="position p₁ (m)", ylabel="position p₂ (m)")
    axes.margins(0.06)
    axes.set_aspect("equal", adjustable="datalim")
    add_legend(axes, columns=3, before=entries)


def _draw_over_time(
    axes: Axes, runs: Sequence[OverlaidRun], values_of: Callable[[RunSeries], FloatArray], label: str
) -> None:
    axes.axhline(0.0, color=ZERO_COLOUR, linewidth=1.0)
    for number, run in enumerate(runs):
        values = values_of(run.series)
        kept = kept_samples([values], bins=BINS)
        colour, dash = line_style(STYLES[number % len(STYLES)])
        times_s = run.series.times_s[kept] - run.origin_s
        axes.plot(times_s, values[kept], color=colour, linestyle=DASHES[dash], label=run.name)
    axes.set(xlabel=ALIGNED_TIME, ylabel=label)
    add_legend(axes, columns=3)
