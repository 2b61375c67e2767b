"""Make the HTML report of a run, or of two over one another: one file that needs neither network nor server."""

from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from typing import Any, Final, NamedTuple

from passafe_protocol.messages import PlantPhase
from passafe_services.tools.compare.comparison import Comparison

from passafe_dashboard.json_text import json_text
from passafe_dashboard.markup import STATIC, TEMPLATES
from passafe_dashboard.palette import PHASE_STYLES, STATUS_STYLES
from passafe_dashboard.reports.comparison_rows import comparison_rows
from passafe_dashboard.reports.report_run import ReportRun
from passafe_dashboard.reports.run_descriptions import description, marks
from passafe_dashboard.run_record.chart_plan import ChartPlan, chart_plans
from passafe_dashboard.run_record.collector import RunCollector
from passafe_dashboard.run_record.run_payload import run_payload
from passafe_dashboard.run_record.signals import SEVERITY
from passafe_dashboard.script_bundle import script_bundle

OUTCOMES: Final = {
    "holds": "Every required property holds",
    "fails": "A required property is violated",
    "unproven": "Not proven: the log does not show the whole run",
}
START: Final = "\nopenReport(JSON.parse(document.getElementById('data').textContent), document);\n"


class ReportParts(NamedTuple):
    """A report for a page that has a frame of its own.

    Attributes:
        title: Heading.
        markup: Its contents, HTML.
        data: What its script reads, see ``static/report/report.js``.
    """

    title: str
    markup: str
    data: dict[str, Any]


def report_page(runs: Sequence[ReportRun], *, title: str, notes: Sequence[str] = ()) -> str:
    """Return the report.

    Args:
        runs: One run, or several that are drawn over one another; scene and charts are those of the first.
        title: Heading.
        notes: Sentences under the verdict.

    Returns:
        HTML that refers to no other file or host.
    """
    parts = report_parts(runs, title=title, notes=notes)
    css = report_style()
    script = inline_script(script_bundle("report/report.js") + START)
    return TEMPLATES.get_template("run_report.html").render(
        title=title,
        markup=parts.markup,
        css=css,
        script=script,
        policy=_policy(css, script),
        data=json_text(parts.data).replace("<", "\\u003c"),
    )


def report_parts(
    runs: Sequence[ReportRun], *, title: str, notes: Sequence[str] = (), comparison: Comparison | None = None
) -> ReportParts:
    """Return the report in parts.

    Args:
        runs: One run, or several that are drawn over one another; scene and charts are those of the first.
        title: Heading.
        notes: Sentences under the verdict.
        comparison: Metrics of the runs side by side, if they are to be listed.
    """
    first = runs[0].record
    plans = chart_plans(first, live=runs[0].verdict.get("driver") == "live")
    planar = first.layout.points > 0
    markup = TEMPLATES.get_template("run_report_body.html").render(
        title=title,
        notes=notes,
        runs=[run.view() for run in runs],
        outcomes=OUTCOMES,
        marks=marks(runs),
        comparison=comparison_rows(comparison) if comparison is not None else (),
        absent=_absent(plans),
        statuses=[(status.name, style) for status, style in STATUS_STYLES.items()],
        has_barriers=bool(first.layout.barriers),
        scene_title="Robot in the plane" if planar else "Joints",
        scene_text=_scene_text(planar, runs),
        scene_note=_scene_note(first),
    )
    return ReportParts(title=title, markup=markup, data=_data(runs, plans))


def _scene_note(record: RunCollector) -> str:
    """Return what is to be seen of the robot."""
    layout = record.layout
    if not layout.points:
        return "Angle of each joint at the cursor, between its limits."
    trail = "Trail until the cursor; what follows is faint."
    has_arrows = layout.drawn is None or layout.drawn.pushes is None
    return f"{trail} Arrows: input asked (dashed) and allowed." if has_arrows else trail


def inline_script(text: str) -> str:
    """Return the text of a script so that no string in it ends the script element."""
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _data(runs: Sequence[ReportRun], plans: Sequence[ChartPlan]) -> dict[str, Any]:
    first = runs[0].record
    return {
        "runs": [run_payload(run.record, label=run.label) | {"offset_s": run.offset_s} for run in runs],
        "charts": [plan.payload() for plan in plans],
        "descriptions": {plan.key: description(plan, first) for plan in plans},
        "bands": {
            "status": {
                str(SEVERITY[status]): {"name": status.name, "colour": style.background}
                for status, style in STATUS_STYLES.items()
            },
            "phase": {str(phase.value): {"name": phase.name, "colour": PHASE_STYLES[phase]} for phase in PlantPhase},
        },
    }


def _absent(plans: Sequence[ChartPlan]) -> list[str]:
    keys = {plan.key for plan in plans}
    reasons = {
        "h": "No barriers: the scenario has none.",
        "links": "No link effects: no injected link dropped, copied or corrupted a message.",
        "latency": "No latencies: the run was simulated in virtual time.",
        "active": "No active rows: no row of the filter's program changed an input.",
    }
    return [reason for key, reason in reasons.items() if key not in keys]


def _scene_text(planar: bool, runs: Sequence[ReportRun]) -> str:
    layout = runs[0].record.layout
    if not planar:
        return f"Angles of {layout.coordinates} joints between their limits, at the cursor."
    obstacles = ", ".join(barrier.name for barrier in layout.barriers if barrier.outline is not None)
    return f"Robot in the plane at the cursor, with its trail. Obstacles: {obstacles or 'none'}."


def report_style() -> str:
    """Return the style sheet of a report."""
    statuses = "".join(
        f'[data-status="{status.name}"] {{ background: {style.background}; color: {style.text}; }}\n'
        for status, style in STATUS_STYLES.items()
    )
    return (STATIC / "run_report.css").read_text("utf-8") + statuses


def _policy(css: str, script: str) -> str:
    """Return the content security policy: this style, this script, nothing from anywhere."""
    allowed = {"style-src": css, "script-src": script}
    hashes = {name: b64encode(sha256(text.encode()).digest()).decode("ascii") for name, text in allowed.items()}
    sources = "; ".join(f"{name} 'sha256-{digest}'" for name, digest in hashes.items())
    return f"default-src 'none'; {sources}; img-src data:; base-uri 'none'; form-action 'none'"
