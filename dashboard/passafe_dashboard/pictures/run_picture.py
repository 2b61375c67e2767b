"""Draw the paper's plots of a run: its path in the plane beside barriers and power margin over time."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from passafe_dashboard.decimation import kept_samples
from passafe_dashboard.palette import INK, LINE_COLOURS, PAPER, TRAIL_COLOUR, ZERO_COLOUR, line_style
from passafe_dashboard.pictures.keep_out import draw_keep_out
from passafe_dashboard.pictures.svg_file import DASHES, add_legend, svg_text
from passafe_dashboard.run_description import descriptions
from passafe_dashboard.run_series import FloatArray, RunSeries

PLANE_SIDE: Final = 440.0
CHART_WIDTH: Final = 520.0
BINS: Final = 400
"""Enough for a chart 450 points wide; lowest and highest samples of each bin are kept."""

PLANE_MARGIN: Final = 0.06
TIME_LABEL: Final = "plant time (s)"

TRAILS: Final = ((TRAIL_COLOUR, "solid"), (LINE_COLOURS[1], "dashed"))
"""Colour and dash of each point's trail."""


class Signal(NamedTuple):
    """One line over time."""

    label: str
    values: FloatArray
    style: int


def run_picture(series: RunSeries, *, title: str) -> str:
    """Return the SVG of a run: its path in the plane, if it has one, beside h and power margin over time."""
    texts = descriptions(series)
    names = [*(["plane"] if series.points else []), *(["h"] if series.barriers else []), "power_margin"]
    return svg_text(
        lambda figure: draw_run(figure, series),
        width=CHART_WIDTH + (PLANE_SIDE if series.points else 0.0),
        height=PLANE_SIDE,
        title=title,
        description=" ".join(texts[name] for name in names),
    )


def draw_run(figure: Figure, series: RunSeries) -> None:
    """Draw the plane, if there is one, on the left, and the charts over time on the right."""
    over_time: list[Callable[[Axes, RunSeries], None]] = [_draw_power_margin]
    if series.barriers:
        over_time.insert(0, _draw_barriers)
    if series.points:
        grid = figure.add_gridspec(len(over_time), 2, width_ratios=(PLANE_SIDE, CHART_WIDTH))
        _draw_plane(figure.add_subplot(grid[:, 0]), series)
        places = [grid[row, 1] for row in range(len(over_time))]
    else:
        grid = figure.add_gridspec(len(over_time), 1)
        places = [grid[row, 0] for row in range(len(over_time))]
    for place, draw in zip(places, over_time, strict=True):
        draw(figure.add_subplot(place), series)


def _draw_plane(axes: Axes, series: RunSeries) -> None:
    entries = draw_keep_out(axes, series)
    positions = [series.position(point) for point in range(series.points)]
    kept = kept_samples([*np.concatenate(positions), *series.h], bins=BINS)
    for number, (p1, p2) in enumerate(positions):
        which = f" {number + 1}" if len(positions) > 1 else ""
        colour, dash = TRAILS[number]
        axes.plot(p1[kept], p2[kept], color=colour, linestyle=DASHES[dash], label=f"trail{which}")
        begin = "start" if number == 0 else "_"  # an underscore keeps it out of the legend
        axes.plot(p1[:1], p2[:1], "s", color=PAPER, markeredgecolor=INK, markersize=7, label=begin)
        axes.plot(p1[-1:], p2[-1:], "o", color=colour, markeredgecolor=PAPER, markersize=10, label=f"robot{which}")
    axes.set(xlabel="position p₁ (m)", ylabel="position p₂ (m)")
    axes.margins(PLANE_MARGIN)
    axes.set_aspect("equal", adjustable="datalim")
    add_legend(axes, columns=4, before=entries)


def _draw_barriers(axes: Axes, series: RunSeries) -> None:
    signals = [Signal(f"h of {series.barriers[i].name}", series.h[i], 2 * i) for i in series.lowest_barriers]
    _draw_over_time(axes, series.times_s, signals, limit="limit: h = 0", least_span=0.02)
    units = sorted({barrier.h_unit for barrier in series.barriers})
    axes.set_ylabel(f"barrier h ({' or '.join(units)})")


def _draw_power_margin(axes: Axes, series: RunSeries) -> None:
    signals = [Signal("power margin h_u", series.power_margin_w, 0)]
    _draw_over_time(axes, series.times_s, signals, limit="limit: h_u = 0", least_span=0.2)
    axes.set_ylabel("power margin (W)")


def _draw_over_time(
    axes: Axes, times_s: FloatArray, signals: Sequence[Signal], *, limit: str, least_span: float
) -> None:
    """Draw signals and the line 0, over an interval of at least ``least_span``."""
    axes.axhline(0.0, color=ZERO_COLOUR, linewidth=1.0, label=limit)
    for signal in signals:
        kept = kept_samples([signal.values], bins=BINS)
        colour, dash = line_style(signal.style)
        axes.plot(times_s[kept], signal.values[kept], color=colour, linestyle=DASHES[dash], label=signal.label)
    low, high = axes.get_ylim()
    if high - low < least_span:
        middle = (low + high) / 2
        axes.set_ylim(middle - least_span / 2, middle + least_span / 2)
    axes.set_xlabel(TIME_LABEL)
    add_legend(axes, columns=3)
