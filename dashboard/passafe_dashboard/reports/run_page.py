"""Make the HTML report of a run: one file that needs neither network nor server."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bokeh.embed import components
from bokeh.model import Model
from bokeh.settings import settings as bokeh_settings

from passafe_dashboard.charts.run_charts import run_charts
from passafe_dashboard.markup import TEMPLATES, report_css
from passafe_dashboard.number_text import MINUS, number, signed
from passafe_dashboard.palette import STATUS_STYLES
from passafe_dashboard.run_description import descriptions
from passafe_dashboard.run_series import RunSeries


class PropertyLine(NamedTuple):
    """One line of the verdict's table, as text."""

    name: str
    outcome: str
    required: str
    worst: str
    at: str
    requirement: str


class TimingLine(NamedTuple):
    """One line of the timing table; percentiles in ``unit``."""

    quantity: str
    unit: str
    percentiles: tuple[str, ...]


def report_page(
    verdict: Mapping[str, Any],
    series: RunSeries,
    *,
    configuration: Mapping[str, Any],
    versions: Mapping[str, str],
) -> str:
    """Return the report.

    Args:
        verdict: Output of ``passafe review --json``; a metric that is missing or null is shown as unknown.
        series: Signals of the run.
        configuration: Effective scenario.
        versions: Version of each package that computed it, by name.

    Returns:
        HTML that refers to no other file or host.
    """
    charts: dict[str, Model] = {**run_charts(series)}
    lines = _property_lines(verdict)
    script, divs = components(charts, wrap_script=False)
    return TEMPLATES.get_template("report.html").render(
        verdict=verdict,
        properties=lines,
        not_required=[line.name for line in lines if line.outcome == "violated" and line.required == "no"],
        facts=_facts(verdict),
        links=verdict.get("links") or (),
        timing=_timing_lines(verdict.get("timing") or {}),
        statuses=[(status.name, style) for status, style in STATUS_STYLES.items()],
        counts=verdict.get("status_counts") or {},
        descriptions=descriptions(series),
        divs=divs,
        configuration=json.dumps(configuration, indent=2, ensure_ascii=False),
        versions=versions,
        css=report_css(),
        bokehjs=inline_script(_bokehjs()),
        script=inline_script(script),
    )


def inline_script(text: str) -> str:
    """Return the text of a script so that no string in it ends the script element."""
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _bokehjs() -> str:
    return (Path(bokeh_settings.bokehjs_path()) / "js" / "bokeh.min.js").read_text("utf-8")


def _property_lines(verdict: Mapping[str, Any]) -> list[PropertyLine]:
    outcomes = {True: "holds", False: "violated", None: "unknown"}
    return [
        PropertyLine(
            name=name,
            outcome=outcomes[entry.get("holds")],
            required="yes" if entry.get("required", True) else "no",
            worst=number(entry.get("worst")),
            at="–" if entry.get("at_s") is None else signed(f"{entry['at_s']:.3f} s"),
            requirement=entry.get("requirement", "").replace(" -", f" {MINUS}"),
        )
        for name, entry in (verdict.get("properties") or {}).items()
    ]


def _facts(verdict: Mapping[str, Any]) -> list[tuple[str, str]]:
    final = verdict.get("final_x")
    gaps = verdict.get("gaps") or {}
    missing = ", ".join(f"{topic} {count}" for topic, count in gaps.items() if count)
    return [
        ("duration", f"{number(verdict.get('duration_s'))} s"),
        ("lowest h", number(verdict.get("h_min"))),
        ("lowest power margin", f"{number(verdict.get('power_margin_min'))} W"),
        ("lowest tank energy", f"{number(verdict.get('tank_min_j'))} J"),
        ("largest ‖u‖", number(verdict.get("u_norm_max"))),
        ("final x", "unknown" if final is None else f"({', '.join(number(value) for value in final)})"),
        ("filter ticks", number(verdict.get("ticks"), 9)),
        ("commands of the operator", (verdict.get("commands") or {}).get("text", "unknown")),
        ("steps skipped", number(verdict.get("steps_skipped"), 9)),
        ("messages missing in the log", missing or ("none" if gaps else "unknown")),
    ]


def _timing_lines(timing: Mapping[str, Any]) -> list[TimingLine]:
    late = [(f"lateness of {name}", "µs", spread) for name, spread in (timing.get("late_us") or {}).items()]
    entries = [
        ("filter step: state in, input out", "µs", timing.get("solve_us")),
        *late,
        ("age of command at the filter", "ms", timing.get("command_age_ms")),
        ("age of state at the filter", "ms", timing.get("state_age_ms")),
        ("operator to plant", "ms", timing.get("operator_to_plant_ms")),
    ]
    return [
        TimingLine(quantity, unit, tuple(number(spread.get(key), 3) for key in ("p50", "p99", "p99_9", "max")))
        for quantity, unit, spread in entries
        if spread is not None
    ]
