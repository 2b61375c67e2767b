"""Describe in words where a run was worst: places to look at, and charts for readers who cannot see them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

from passafe_dashboard.number_text import number
from passafe_dashboard.reports.report_run import ReportRun, time_text
from passafe_dashboard.run_record.bucket_table import Extreme
from passafe_dashboard.run_record.chart_plan import ChartLine, ChartPlan, lowest_barriers
from passafe_dashboard.run_record.collector import RunCollector

NS_PER_S: Final = 1e9
MS_PER_S: Final = 1e3
MOST_DESCRIBED: Final = 4


class Mark(NamedTuple):
    """A place to look at.

    Attributes:
        kind: ``violated`` or ``extreme``.
        text: In words.
        at_s: On the page's time axis, s.
        time: The run's own plant time, as text.
    """

    kind: str
    text: str
    at_s: float
    time: str


def marks(runs: Sequence[ReportRun]) -> list[Mark]:
    """Return the places to look at: what was violated, what is unknown, then where the run was worst."""
    found: list[Mark] = []
    for run in runs:
        prefix = f"{run.label}: " if len(runs) > 1 else ""
        for name, entry in _violated(run.verdict):
            kept = "violated" if entry["holds"] is False else "unknown"
            asked = "" if entry.get("required", True) else " (not required)"
            worst = "" if entry.get("worst") is None else f", worst {number(entry['worst'], 3)}"
            text = f"{prefix}{name} {kept}{asked}{worst}"
            found.append(Mark("violated", text, entry["at_s"] + run.offset_s, time_text(entry["at_s"])))
    for run in runs:
        prefix = f"{run.label}: " if len(runs) > 1 else ""
        for text, extreme in _extremes(run.record):
            at_s = extreme.at_ns / NS_PER_S
            found.append(Mark("extreme", f"{prefix}{text}", at_s + run.offset_s, time_text(at_s)))
    return found


def _violated(verdict: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    entries = (verdict.get("properties") or {}).items()
    bad = [(name, entry) for name, entry in entries if entry.get("holds") is not True and entry.get("at_s") is not None]
    yield from sorted(bad, key=lambda item: (item[1]["holds"] is None, not item[1].get("required", True)))


def _extremes(run: RunCollector) -> Iterator[tuple[str, Extreme]]:
    held = run.ticks.greatest("held_back")
    if held is not None and held.value > 0:
        yield f"most held back, {number(held.value, 3)} {run.scenario.plant.robot_model.input_unit}", held
    for i in lowest_barriers(run)[:1]:
        lowest = run.states.least(f"h_{i}")
        if lowest is not None:
            yield f"closest to a limit: {run.layout.barriers[i].name}, h = {run.layout.h_text(i, lowest.value)}", lowest
    wanted = [("lowest power margin", run.states.least("power_margin_w"), "W")]
    if run.scenario.filter.passivity.kind == "tank":
        wanted.append(("lowest tank", run.ticks.least("tank_j"), "J"))
    oldest = run.ticks.greatest("command_age_ms")
    wanted.append(("oldest command", oldest if oldest is not None and oldest.value > 0 else None, "ms"))
    for what, extreme, unit in wanted:
        if extreme is not None:
            shown = (
                (extreme.value / MS_PER_S, "s") if unit == "ms" and extreme.value >= MS_PER_S else (extreme.value, unit)
            )
            yield f"{what}, {number(shown[0], 3)} {shown[1]}", extreme


def description(plan: ChartPlan, run: RunCollector) -> str:
    """Return what a chart shows, in words."""
    said = [text for line in plan.lines if not line.hidden and (text := _range(line, run, plan.unit))]
    more = f"; {len(said) - MOST_DESCRIBED} more" if len(said) > MOST_DESCRIBED else ""
    return f"{plan.title} over plant time. {'; '.join(said[:MOST_DESCRIBED])}{more}."


def _range(line: ChartLine, run: RunCollector, unit: str) -> str:
    table = {"ticks": run.ticks, "states": run.states}.get(line.table)
    if table is None or line.column not in table.envelopes or line.column in ("status", "phase"):
        return ""
    low, high = table.least(line.column), table.greatest(line.column)
    if low is None or high is None:
        return ""
    name = f"{line.label} of {line.choice}" if line.choice and line.choice != line.label else line.label
    return f"{name} from {number(low.value, 3)} to {number(high.value, 3)} {unit}".rstrip()
