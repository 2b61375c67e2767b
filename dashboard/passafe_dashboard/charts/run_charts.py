"""Make the charts of a whole run from its arrays, for the report."""

from typing import Final

import numpy as np
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure

from passafe_dashboard.charts.barriers import h_chart
from passafe_dashboard.charts.energy import power_margin_chart
from passafe_dashboard.charts.over_time import full_range
from passafe_dashboard.charts.plane import plane_chart
from passafe_dashboard.charts.regions import Drawing
from passafe_dashboard.charts.timeline import status_chart
from passafe_dashboard.columns import PLACES, POWER_MARGIN, START, STATUS, TIME, ZERO, ColumnLayout, measured_h
from passafe_dashboard.decimation import kept_samples
from passafe_dashboard.run_series import RunSeries

BINS: Final = 2000
"""A chart a few hundred pixels wide shows no more; lowest and highest samples of each bin are kept."""


def run_charts(series: RunSeries, *, bins: int = BINS) -> dict[str, figure]:
    """Return the charts of a run: plane (if a point moves in it), h (if any barrier), power_margin, status (if any)."""
    layout = ColumnLayout(barriers=series.barriers, levels=(1,) * len(series.barriers))
    signals = _signals(series, bins)
    x_range = full_range()
    charts = {"plane": _plane(series, bins)} if series.points else {}
    if series.barriers:
        charts["h"] = h_chart(layout, ticks=None, states=signals, x_range=x_range, shown=series.lowest_barriers)
    charts["power_margin"] = power_margin_chart(source=signals, x_range=x_range, with_slack=False)
    if series.statuses:
        charts["status"] = status_chart(source=_statuses(series), x_range=x_range)
    return charts


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
    return plane_chart(
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
            STATUS: [span.status.severity for span in series.statuses],
        }
    )
