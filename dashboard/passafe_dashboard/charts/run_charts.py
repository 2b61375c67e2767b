"""Charts of a whole run, made from its arrays: for the report and the pictures."""

from typing import Final

import numpy as np
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure

from passafe_dashboard.charts.barriers import MOST_SHOWN, h_figure
from passafe_dashboard.charts.energy import power_margin_figure
from passafe_dashboard.charts.over_time import full_range
from passafe_dashboard.charts.plane import plane_figure
from passafe_dashboard.charts.regions import Drawing
from passafe_dashboard.charts.timeline import status_figure
from passafe_dashboard.columns import PLACES, POWER_MARGIN, START, STATUS, TIME, ZERO, ColumnLayout, measured_h
from passafe_dashboard.decimation import kept_samples
from passafe_dashboard.reports.run_series import RunSeries

BINS: Final = 2000
"""A chart a few hundred pixels wide shows no more; lowest and highest samples of each bin stay."""


def run_charts(series: RunSeries, *, bins: int = BINS) -> dict[str, figure]:
    """Charts of a run: plane (if a point moves in it), h (if there are barriers), power_margin, status (if any)."""
    layout = ColumnLayout(barriers=series.barriers, levels=(1,) * len(series.barriers))
    signals = _signals(series, bins)
    x_range = full_range()
    charts = {"plane": _plane(series, bins)} if series.points else {}
    if series.barriers:
        charts["h"] = h_figure(layout, ticks=None, states=signals, x_range=x_range, shown=lowest_barriers(series))
    charts["power_margin"] = power_margin_figure(source=signals, x_range=x_range, with_slack=False)
    if series.statuses:
        charts["status"] = status_figure(source=_statuses(series), x_range=x_range)
    return charts


def lowest_barriers(series: RunSeries) -> tuple[int, ...]:
    """Numbers of the barriers that a chart shows: all, or those that came lowest if there are many."""
    lowest = series.h.min(axis=1)
    return tuple(sorted(int(i) for i in np.argsort(lowest, kind="stable")[:MOST_SHOWN]))


def _signals(series: RunSeries, bins: int) -> ColumnDataSource:
    kept = kept_samples([*series.h, series.power_margin_w], bins=bins)
    columns = {TIME: series.times_s[kept], ZERO: np.zeros(len(kept))}
    columns |= {measured_h(i): h[kept] for i, h in enumerate(series.h)}
    columns[POWER_MARGIN] = series.power_margin_w[kept]
    return ColumnDataSource(columns)


def _plane(series: RunSeries, bins: int) -> figure:
    positions = [series.position(point) for point in range(series.points)]
    coordinates = {
        column: values
        for place, position in zip(PLACES, positions, strict=False)
        for column, values in zip(place, position, strict=True)
    }
    kept = kept_samples([*coordinates.values(), *series.h], bins=bins)
    return plane_figure(
        series.barriers,
        trail=ColumnDataSource({column: values[kept] for column, values in coordinates.items()}),
        robot=ColumnDataSource({column: values[-1:] for column, values in coordinates.items()}),
        starts=[(float(p1[0]), float(p2[0])) for p1, p2 in positions],
        drawing=Drawing(begin_s=float(series.times_s[0]), end_s=float(series.times_s[-1])),
    )


def _statuses(series: RunSeries) -> ColumnDataSource:
    return ColumnDataSource(
        {
            START: [span.start_s for span in series.statuses],
            TIME: [span.end_s for span in series.statuses],
            STATUS: [span.status.value for span in series.statuses],
        }
    )
