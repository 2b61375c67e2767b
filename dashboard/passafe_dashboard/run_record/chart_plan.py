"""Plan the charts of a run's report: which signals, in which unit, on which scale."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, Literal

from passafe_dashboard.run_record.collector import RunCollector

MOST_LINES: Final = 8
"""Lines that a chart shows at first; a reader may add the others."""

PAIR: Final = 2
"""Inputs in one chart: those of a point in the plane."""

RESIDUAL_LINEAR: Final = 1e-12
PSI_LINEAR: Final = 0.1


@dataclass(frozen=True, kw_only=True)
class ChartLine:
    """A signal in a chart.

    Attributes:
        table: Table of its column: ticks, states or counts.
        column: The column.
        label: What the legend calls it.
        style: Number of its colour and dash.
        dash: Whether it is dashed, to tell what was asked from what was sent.
        unit: Unit of the signal where it is not the chart's.
        hidden: Whether the reader has to ask for it.
        choice: Which choice of the chart shows it; every one if it is empty.
    """

    table: str
    column: str
    label: str
    style: int
    dash: bool = False
    unit: str = ""
    hidden: bool = False
    choice: str = ""


@dataclass(frozen=True, kw_only=True)
class ChartPlan:
    """One chart over time.

    Attributes:
        key: Its name in the page.
        title: Heading.
        unit: Unit of the vertical axis; empty for a share.
        lines: Its signals.
        kind: Lines, a band for each status and phase, or a band for each row of the filter's program.
        note: What a reader has to know.
        zero: Whether 0 is a limit, drawn and always in view.
        least_span: Least length of the vertical axis, so that rounding errors do not fill the chart.
        linear: Half-width of the linear part of a signed-log axis; 0 for a linear axis.
        choices: Names of what a reader can choose between.
    """

    key: str
    title: str
    unit: str
    lines: tuple[ChartLine, ...]
    kind: Literal["lines", "status", "rows"] = "lines"
    note: str = ""
    zero: bool = False
    least_span: float = 1e-9
    linear: float = 0.0
    choices: tuple[str, ...] = ()

    def payload(self) -> dict[str, Any]:
        """Return the plan as JSON values."""
        return asdict(self)


def chart_plans(run: RunCollector, *, live: bool) -> list[ChartPlan]:
    """Return the charts of a run's report, in the order of the page."""
    return [plan for plan in _plans(run, live=live) if plan.lines]


def _plans(run: RunCollector, *, live: bool) -> Iterator[ChartPlan]:
    yield ChartPlan(
        key="status",
        title="Status",
        unit="",
        kind="status",
        lines=_lines("ticks", [("status", "filter")]) + _lines("states", [("phase", "plant")]),
        note="The worst of each stretch is drawn.",
    )
    yield _barriers(run)
    yield _chains(run)
    yield from _energy(run)
    yield from _inputs(run)
    yield ChartPlan(
        key="active",
        title="Active rows",
        unit="",
        kind="rows",
        lines=_lines("ticks", _active_rows(run)),
        note="Rows of the filter's program that changed the input; faint where not in every tick.",
    )
    yield _override(run)
    yield from _timing(live=live)
    yield _rates(run)
    yield _link_effects(run)
    yield ChartPlan(
        key="residual",
        title="Model residual",
        unit="",
        lines=_lines("states", [("residual", "difference")]),
        note="Distance of each state from the exact model's step from the state before, relative to 1 + ‖x‖.",
        zero=True,
        linear=RESIDUAL_LINEAR,
    )
    layout = run.layout
    if not layout.points:
        yield ChartPlan(
            key="coordinates",
            title="Joint angles",
            unit=run.scenario.plant.robot_model.position_unit,
            lines=_lines("states", [(f"q_{i}", f"joint {i + 1}") for i in range(layout.coordinates)]),
        )


def _barriers(run: RunCollector) -> ChartPlan:
    barriers = run.layout.barriers
    units = sorted({run.layout.h_unit(i) for i in range(len(barriers))} - {""})
    shown = lowest_barriers(run)[:MOST_LINES]
    lines = tuple(
        ChartLine(
            table="states",
            column=f"h_{i}",
            label=barrier.name,
            style=i,
            unit=run.layout.h_unit(i),
            hidden=i not in shown,
        )
        for i, barrier in enumerate(barriers)
    )
    note = "Recomputed from the plant's states; below 0 the robot is where it must not be."
    if len(barriers) > MOST_LINES:
        note += f" The {MOST_LINES} that came lowest are drawn; choose others in the legend."
    return ChartPlan(
        key="h", title="Barriers h", unit=" or ".join(units), lines=lines, note=note, zero=True, least_span=0.02
    )


def lowest_barriers(run: RunCollector) -> list[int]:
    """Return the numbers of the barriers, the one that came lowest first."""
    lowest = [run.states.least(f"h_{i}") for i in range(len(run.layout.barriers))]
    worst = [float("inf") if extreme is None else extreme.value for extreme in lowest]
    return sorted(range(len(worst)), key=worst.__getitem__)


def _chains(run: RunCollector) -> ChartPlan:
    layout = run.layout
    subscripts = "₀₁₂₃₄₅₆₇₈₉"
    order = lowest_barriers(run)
    lines = tuple(
        ChartLine(
            table="ticks",
            column=f"psi_{i}_{level}",
            label=f"ψ{subscripts[level]}",
            style=level,
            choice=layout.barriers[i].name,
        )
        for i in order
        for level in range(layout.levels[i])
    )
    return ChartPlan(
        key="psi",
        title="ψ chain",
        unit="",
        lines=lines,
        note="As the filter reported it, on a signed-log axis; all but the last are ≥ 0 in the protected set.",
        zero=True,
        linear=PSI_LINEAR,
        choices=tuple(layout.barriers[i].name for i in order),
    )


def _energy(run: RunCollector) -> Iterator[ChartPlan]:
    passivity = run.scenario.filter.passivity
    slack = ChartLine(table="ticks", column="slack_w", label="slack granted", style=1)
    margin = ChartLine(table="states", column="power_margin_w", label="power margin", style=0)
    tank = passivity.kind == "tank"
    yield ChartPlan(
        key="power",
        title="Power margin",
        unit="W",
        lines=(margin, slack),
        note="Below 0 the robot gives out more than it was given"
        + (", which the tank has to pay." if tank else "; slack is what the filter granted for safety."),
        zero=True,
        least_span=0.2,
    )
    stored = ChartLine(table="states", column="stored_j", label="stored in the robot", style=1)
    level = (ChartLine(table="ticks", column="tank_j", label="tank", style=0),) if tank else ()
    yield ChartPlan(
        key="energy",
        title="Tank and stored energy" if tank else "Stored energy",
        unit="J",
        lines=(*level, stored),
        note=f"The tank's reserve is {passivity.tank_reserve_j:g} J: only safety may draw below it." if tank else "",
        zero=True,
        least_span=0.1,
    )


def _inputs(run: RunCollector) -> Iterator[ChartPlan]:
    layout = run.layout
    for first in range(0, layout.inputs, PAIR):
        lines: list[ChartLine] = []
        for place, i in enumerate(range(first, min(first + PAIR, layout.inputs))):
            lines.append(
                ChartLine(table="ticks", column=f"asked_{i}", label=f"asked u{i + 1}", style=2 * place, dash=True)
            )
            lines.append(ChartLine(table="ticks", column=f"sent_{i}", label=f"allowed u{i + 1}", style=2 * place + 1))
        of = f", {_numbered(first, layout.inputs)}" if layout.inputs > PAIR else ""
        yield ChartPlan(
            key=f"input-{first}",
            title=f"Asked and allowed input{of}",
            unit=run.scenario.plant.robot_model.input_unit,
            lines=tuple(lines),
            least_span=0.1,
            zero=False,
        )


def _numbered(first: int, inputs: int) -> str:
    last = min(first + PAIR, inputs)
    return f"inputs {first + 1} and {last}" if last > first + 1 else f"input {last}"


def _active_rows(run: RunCollector) -> list[tuple[str, str]]:
    named = [(f"active_{i}", name) for i, name in enumerate(run.layout.rows)]
    greatest = {column: run.ticks.greatest(column) for column, _ in named}
    return [(column, name) for column, name in named if (found := greatest[column]) is not None and found.value > 0]


def _override(run: RunCollector) -> ChartPlan:
    unit = run.scenario.plant.robot_model.input_unit
    share, held, room = "share allowed", f"held back ({unit})", f"room to infeasibility ({unit})"
    named = (("allowed", share), ("held_back", held), ("room", room))
    lines = tuple(
        ChartLine(table="ticks", column=column, label=name, style=style, choice=name)
        for style, (column, name) in enumerate(named)
    )
    return ChartPlan(
        key="override",
        title="Override",
        unit="",
        lines=lines,
        note="How much of the operator's request would have passed unchanged; no line where the filter did not know.",
        zero=True,
        least_span=0.01,
        choices=(share, held, room),
    )


def _timing(*, live: bool) -> Iterator[ChartPlan]:
    ages = _lines("ticks", [("state_age_ms", "plant state at the filter"), ("command_age_ms", "command at the filter")])
    lead = ChartLine(table="states", column="lead_ms", label="input came before its time by", style=2)
    yield ChartPlan(key="ages", title="Ages", unit="ms", lines=(*ages, lead), zero=True, least_span=5.0)
    late = (
        ChartLine(table="ticks", column="step_us", label="filter step", style=0),
        ChartLine(table="ticks", column="late_us", label="filter late", style=1),
        ChartLine(table="states", column="late_us", label="plant late", style=2),
    )
    yield ChartPlan(
        key="latency",
        title="Latencies",
        unit="µs",
        lines=late if live else (),
        note="How long a filter step took, and how late steps began.",
        zero=True,
        least_span=10.0,
    )


def _rates(run: RunCollector) -> ChartPlan:
    topics = [name for name in ("commands", "ticks", "inputs", "states") if name in run.counts.names]
    return ChartPlan(
        key="rates", title="Rates", unit="1/s", lines=_lines("counts", [(t, t) for t in topics]), zero=True
    )


def _link_effects(run: RunCollector) -> ChartPlan:
    effects = [name for name in run.counts.names if ":" in name]
    return ChartPlan(
        key="links",
        title="Link effects",
        unit="1/s",
        lines=_lines("counts", [(name, name) for name in effects]),
        note="Messages that the injected links dropped, copied or corrupted.",
        zero=True,
    )


def _lines(table: str, named: Iterable[tuple[str, str]]) -> tuple[ChartLine, ...]:
    pairs: Sequence[tuple[str, str]] = tuple(named)
    return tuple(
        ChartLine(table=table, column=column, label=label, style=style) for style, (column, label) in enumerate(pairs)
    )
