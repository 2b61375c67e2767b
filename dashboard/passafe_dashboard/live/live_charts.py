"""Plan the charts over time of the engineers' sheet, in the words of the report's."""

from passafe_dashboard.columns import (
    COMMAND_AGE,
    POWER_MARGIN,
    SLACK,
    STATE_AGE,
    STATUS,
    TANK,
    ColumnLayout,
    measured_h,
    psi,
)
from passafe_dashboard.run_record.chart_plan import PSI_LINEAR, ChartLine, ChartPlan


def live_charts(layout: ColumnLayout) -> list[ChartPlan]:
    """Return the charts for a scenario's columns; those without a line are left out."""
    names = layout.names
    plans = [
        ChartPlan(key="status", title="Filter status", unit="", kind="status", lines=(_tick(STATUS, "filter", 0),)),
        ChartPlan(
            key="h",
            title="Barriers h",
            unit=layout.h_unit,
            zero=True,
            lines=tuple(
                ChartLine(table="states", column=measured_h(i), label=name, style=i) for i, name in enumerate(names)
            ),
        ),
        ChartPlan(
            key="chain",
            title="ψ chain",
            unit="",
            zero=True,
            linear=PSI_LINEAR,
            choices=names,
            lines=tuple(
                ChartLine(
                    table="ticks", column=psi(i, level), label=f"ψ{_subscript(level)}", style=level, choice=names[i]
                )
                for i, level in layout.chain
            ),
        ),
        ChartPlan(
            key="power",
            title="Power margin and slack",
            unit="W",
            zero=True,
            least_span=0.1,
            lines=(_tick(POWER_MARGIN, "power margin", 0), _tick(SLACK, "slack", 1)),
        ),
        ChartPlan(
            key="tank", title="Energy tank", unit="J", zero=True, least_span=0.1, lines=(_tick(TANK, "level", 0),)
        ),
        ChartPlan(
            key="ages",
            title="Ages of content",
            unit="ms",
            zero=True,
            least_span=5.0,
            lines=(_tick(STATE_AGE, "state", 0), _tick(COMMAND_AGE, "command", 1)),
        ),
    ]
    return [plan for plan in plans if plan.lines]


def _tick(column: str, label: str, style: int) -> ChartLine:
    return ChartLine(table="ticks", column=column, label=label, style=style)


def _subscript(level: int) -> str:
    return str(level).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
