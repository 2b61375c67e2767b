"""Make the charts of the filter's status over time, and of the ages of its inputs."""

from bokeh.models import ColumnDataSource, FixedTicker, LinearColorMapper, Range, Range1d
from bokeh.plotting import figure
from bokeh.transform import transform
from passafe_protocol.messages import BY_SEVERITY

from passafe_dashboard.charts.over_time import TIME_LABEL, Trace, time_chart
from passafe_dashboard.charts.style import plain_chart
from passafe_dashboard.columns import COMMAND_AGE, START, STATE_AGE, STATUS, TIME
from passafe_dashboard.palette import STATUS_STYLES


def status_chart(*, source: ColumnDataSource, x_range: Range) -> figure:
    """Return the chart with a row for each filter status, the worst on top.

    Args:
        source: Each of its rows is a bar; its status is given by its severity.
        x_range: Of the time.
    """
    chart = plain_chart(name="status", x_label=TIME_LABEL, y_label="filter status", x_range=x_range, height=220)
    chart.y_range = Range1d(start=0.5, end=len(BY_SEVERITY) + 0.5)
    chart.yaxis.ticker = FixedTicker(ticks=[status.severity for status in BY_SEVERITY])
    chart.yaxis.major_label_overrides = {status.severity: status.name for status in BY_SEVERITY}
    chart.ygrid.grid_line_alpha = 0.4
    colours = LinearColorMapper(
        palette=[STATUS_STYLES[status].background for status in BY_SEVERITY],
        low=0.5,
        high=len(BY_SEVERITY) + 0.5,
    )
    chart.hbar(
        y=STATUS,
        left=START,
        right=TIME,
        height=0.8,
        source=source,
        fill_color=transform(STATUS, colours),
        line_color=transform(STATUS, colours),
    )
    return chart


def age_chart(*, ticks: ColumnDataSource, x_range: Range) -> figure:
    """Return the chart of the age of state and command at each decision; the highest of each bin."""
    return time_chart(
        [
            Trace(source=ticks, column=STATE_AGE, label="state", style=0),
            Trace(source=ticks, column=COMMAND_AGE, label="command", style=1),
        ],
        name="ages",
        y_label="age at decision (ms)",
        x_range=x_range,
        least_span=5.0,
    )
