"""The HTML report: one file that needs nothing else, neither network nor server."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from bokeh.embed import components
from bokeh.model import Model
from bokeh.settings import settings as bokeh_settings

from passafe_dashboard.charts.run_charts import lowest_barriers, run_charts
from passafe_dashboard.markup import TEMPLATES, report_css
from passafe_dashboard.palette import STATUS_STYLES
from passafe_dashboard.reports.run_series import RunSeries

MINUS: Final = "−"


class PropertyLine(NamedTuple):
    """A line of the verdict's table, in words."""

    name: str
    outcome: str
    required: str
    worst: str
    at: str
    demand: str


class TimingLine(NamedTuple):
    """A line of the timing table; percentiles in ``unit``."""

    what: str
    unit: str
    percentiles: tuple[str, ...]


def report_page(
    verdict: Mapping[str, Any],
    series: RunSeries,
    *,
    configuration: Mapping[str, Any],
    versions: Mapping[str, str],
) -> str:
    """Make the report.

    Args:
        verdict: What ``passafe review --json`` prints; a figure that is missing or null is shown as unknown.
        series: Signals of the run.
        configuration: Effective scenario.
        versions: Version of what it was computed with, by name.

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
    """Text of a script so that no string in it ends the element that it stands in."""
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _bokehjs() -> str:
    return (Path(bokeh_settings.bokehjs_path()) / "js" / "bokeh.min.js").read_text("utf-8")


def number(value: object, digits: int = 4) -> str:
    """A number as the report writes it; ``unknown`` for what is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return "unknown"
    return signed(f"{value:.{digits}g}")


def signed(text: str) -> str:
    """Text of numbers with minus signs instead of hyphens."""
    return text.replace("-", MINUS)


def _property_lines(verdict: Mapping[str, Any]) -> list[PropertyLine]:
    outcomes = {True: "holds", False: "violated", None: "unknown"}
    return [
        PropertyLine(
            name=name,
            outcome=outcomes[entry.get("holds")],
            required="yes" if entry.get("required", True) else "no",
            worst=number(entry.get("worst")),
            at="–" if entry.get("at_s") is None else signed(f"{entry['at_s']:.3f} s"),
            demand=entry.get("demand", "").replace(" -", f" {MINUS}"),
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
        ("ticks missed", number(verdict.get("steps_skipped"), 9)),
        ("messages missing in the log", missing or ("none" if gaps else "unknown")),
    ]


def _timing_lines(timing: Mapping[str, Any]) -> list[TimingLine]:
    late = [(f"lateness of {name}", "µs", spread) for name, spread in (timing.get("late_us") or {}).items()]
    entries = [
        ("filter step: state in, input out", "µs", timing.get("solve_us")),
        *late,
        ("age of command at the filter", "ms", timing.get("command_age_ms")),
        ("operator to plant", "ms", timing.get("operator_to_plant_ms")),
    ]
    return [
        TimingLine(what, unit, tuple(number(spread.get(key), 3) for key in ("p50", "p99", "p99_9", "max")))
        for what, unit, spread in entries
        if spread is not None
    ]


def descriptions(series: RunSeries) -> dict[str, str]:
    """What each chart shows, for who cannot see it."""
    names = ", ".join(barrier.name for barrier in series.barriers if barrier.outline is not None)
    shown = lowest_barriers(series)
    lowest_h = "; ".join(
        f"{series.barriers[i].name} lowest sample {number(h.min().item())} at {series.times_s[h.argmin()]:.3f} s"
        for i, h in ((i, series.h[i]) for i in shown)
    )
    if len(shown) < len(series.barriers):
        rest = np.delete(series.h, shown, axis=0)
        lowest_h += f"; {len(rest)} others not shown, none below {number(rest.min().item())}"
    worst = series.power_margin_w.argmin()
    margin = number(series.power_margin_w[worst].item())
    return {
        "plane": f"{_paths(series)}. Obstacles: {names or 'none'}.",
        "h": f"Barrier values over plant time with the line h = 0: {lowest_h}.",
        "power_margin": (
            f"Power margin over plant time with the line 0: lowest sample {margin} W at {series.times_s[worst]:.3f} s."
        ),
        "status": "A lane for each filter status; a bar where the filter's ticks had it.",
    }


def _paths(series: RunSeries) -> str:
    paths = []
    for point in range(series.points):
        p1, p2 = series.position(point)
        which = f" {point + 1}" if series.points > 1 else ""
        ends = f"({p1[0]:.3f}, {p2[0]:.3f}) m to ({p1[-1]:.3f}, {p2[-1]:.3f}) m"
        paths.append(signed(f"Path of the robot{which} from {ends}"))
    return ". ".join(paths)
