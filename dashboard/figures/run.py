"""Charts of a whole run, made from its arrays: for the report and the pictures."""

from typing import Final

import numpy as np
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure

from dashboard.columns import P1, P2, POWER_MARGIN, START, STATUS, TIME, ZERO, Layout, measured_h
from dashboard.decimation import kept_samples
from dashboard.figures.barriers import h_figure
from dashboard.figures.energy import power_margin_figure
from dashboard.figures.over_time import full_range
from dashboard.figures.plane import plane_figure
from dashboard.figures.timeline import status_figure
from dashboard.series import RunSeries

BINS: Final = 2000
"""A chart a few hundred pixels wide shows no more; lowest and highest samples of each bin stay."""


def run_charts(series: RunSeries, *, bins: int = BINS) -> dict[str, figure]:
    """Charts of a run: plane, h (if there are barriers), power_margin, status (if there are ticks)."""
    layout = Layout(obstacles=series.obstacles, levels=(1,) * len(series.obstacles))
    signals = _signals(series, bins)
    x_range = full_range()
    charts = {"plane": _plane(series, bins)}
    if series.obstacles:
        charts["h"] = h_figure(layout, ticks=None, states=signals, x_range=x_range)
    charts["power_margin"] = power_margin_figure(source=signals, x_range=x_range, with_slack=False)
    if series.statuses:
        charts["status"] = status_figure(source=_statuses(series), x_range=x_range)
    return charts


def _signals(series: RunSeries, bins: int) -> ColumnDataSource:
    kept = kept_samples([*series.h, series.power_margin_w], bins=bins)
    columns = {TIME: series.times_s[kept], ZERO: np.zeros(len(kept))}
    columns |= {measured_h(i): h[kept] for i, h in enumerate(series.h)}
    columns[POWER_MARGIN] = series.power_margin_w[kept]
    return ColumnDataSource(columns)


def _plane(series: RunSeries, bins: int) -> figure:
    p1, p2 = series.position
    kept = kept_samples([p1, p2, *series.h], bins=bins)
    return plane_figure(
        series.obstacles,
        trail=ColumnDataSource({P1: p1[kept], P2: p2[kept]}),
        robot=ColumnDataSource({P1: p1[-1:], P2: p2[-1:]}),
        start=(float(p1[0]), float(p2[0])),
    )


def _statuses(series: RunSeries) -> ColumnDataSource:
    return ColumnDataSource(
        {
            START: [span.start_s for span in series.statuses],
            TIME: [span.end_s for span in series.statuses],
            STATUS: [span.status.value for span in series.statuses],
        }
    )
