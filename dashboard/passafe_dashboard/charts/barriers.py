"""Make the charts of the barriers: h, whose sign decides safety, and ψ₁ … ψ_r, which lead to the input."""

from typing import Final

from bokeh.models import ColumnDataSource, Range
from bokeh.plotting import figure

from passafe_dashboard.charts.over_time import Trace, time_chart
from passafe_dashboard.columns import ColumnLayout, measured_h, psi, signed_log, signed_log_column

SUBSCRIPTS = "₀₁₂₃₄₅₆₇₈₉"

MOST_WITH_FILTER: Final = 8
"""Barriers up to which the page's chart draws the filter's h beside the measured one."""


def h_chart(
    layout: ColumnLayout,
    *,
    ticks: ColumnDataSource,
    states: ColumnDataSource,
    x_range: Range,
) -> figure:
    """Return the chart of h at the plant's state and, with few barriers, as predicted by the filter.

    Args:
        layout: Columns of the scenario.
        ticks: Table of the filter.
        states: Table of the plant.
        x_range: Time range.
    """
    traces = []
    step = 2 if len(layout.names) <= MOST_WITH_FILTER else 1
    for index, name in enumerate(layout.names):
        style = step * index
        traces.append(Trace(source=states, column=measured_h(index), label=f"h of {name}, measured", style=style))
        if step > 1:
            traces.append(Trace(source=ticks, column=psi(index, 0), label=f"h of {name}, filter", style=style + 1))
    return time_chart(
        traces,
        name="h",
        y_label=f"barrier h ({layout.h_unit})",
        x_range=x_range,
        least_span=0.02,
        height=240,
        zero_label="limit: h = 0",
    )


def chain_chart(layout: ColumnLayout, *, ticks: ColumnDataSource, x_range: Range) -> figure | None:
    """Return the chart of ψ₁ … ψ_r of every barrier over time on a signed-log axis; ``None`` if there is none."""
    traces = [
        Trace(
            source=ticks,
            column=signed_log_column(psi(index, level)),
            shown=psi(index, level),
            label=f"ψ{SUBSCRIPTS[level]} of {layout.names[index]}",
            style=style,
        )
        for style, (index, level) in enumerate((i, k) for i, k in layout.chain if k > 0)
    ]
    if not traces:
        return None
    return time_chart(
        traces,
        name="chain",
        y_label="ψᵢ (unit of h·s⁻ⁱ), signed log",
        x_range=x_range,
        least_span=2 * signed_log(1.0),
        zero_label="limit: ψ = 0",
        y_ticks=signed_log_ticks(),
        height=240,
    )


def signed_log_ticks() -> dict[float, str]:
    """Return places and texts of the ticks 0, ±0.1, ±1, …, ±10⁸ on a signed-log axis."""
    ticks = {0.0: "0"}
    for exponent in range(-1, 9):
        text = f"{10.0**exponent:g}" if exponent < 4 else f"1e{exponent}"  # noqa: PLR2004 - five digits are long
        ticks[signed_log(10.0**exponent)] = text
        ticks[-signed_log(10.0**exponent)] = f"−{text}"
    return ticks
