"""Make the charts of energy: the power margin, negative where the robot generates energy, and the tank."""

from bokeh.models import ColumnDataSource, Range
from bokeh.plotting import figure

from passafe_dashboard.charts.over_time import Trace, time_chart
from passafe_dashboard.columns import POWER_MARGIN, SLACK, TANK


def power_margin_chart(*, source: ColumnDataSource, x_range: Range) -> figure:
    """Return the chart of h_u = yᵀu − V̇ and of the slack δ of the passivity row over time."""
    return time_chart(
        [
            Trace(source=source, column=POWER_MARGIN, label="power margin h_u", style=0),
            Trace(source=source, column=SLACK, label="slack δ", style=1),
        ],
        name="power_margin",
        y_label="power margin (W)",
        x_range=x_range,
        least_span=0.2,
        zero_label="limit: h_u = 0",
    )


def tank_chart(*, ticks: ColumnDataSource, x_range: Range) -> figure:
    """Return the chart of the energy E in the tank over time."""
    return time_chart(
        [Trace(source=ticks, column=TANK, label="tank E", style=0)],
        name="tank",
        y_label="tank energy (J)",
        x_range=x_range,
        least_span=0.2,
        zero_label="empty: E = 0",
    )
