"""Put into words what a report's tables say of one run."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from passafe_dashboard.number_text import MINUS, number, signed
from passafe_dashboard.run_record.collector import RunCollector
from passafe_dashboard.run_record.run_events import REVIEW
from passafe_dashboard.run_record.run_payload import run_events


class PropertyLine(NamedTuple):
    """One line of the verdict's table, as text."""

    name: str
    outcome: str
    required: str
    worst: str
    at: str
    at_s: float | None
    requirement: str


class TimingLine(NamedTuple):
    """One line of the timing table; percentiles in ``unit``."""

    quantity: str
    unit: str
    percentiles: tuple[str, ...]


class EventLine(NamedTuple):
    """One line of the list of events."""

    at_s: float
    time: str
    severity: str
    source: str
    text: str


@dataclass(frozen=True, kw_only=True)
class ReportRun:
    """One run of a report: what was recorded of it, and what the review says.

    Attributes:
        label: What a report of several runs calls it.
        record: Its finished record.
        verdict: Output of ``passafe review --json``; a metric that is missing or null is shown as unknown.
        configuration: Its effective scenario.
        versions: Version of each package that computed it, by name.
        offset_s: Seconds to add to its plant time, so that it lies over another run.
    """

    label: str
    record: RunCollector
    verdict: Mapping[str, Any]
    configuration: Mapping[str, Any]
    versions: Mapping[str, str]
    offset_s: float = 0.0

    def view(self) -> dict[str, Any]:
        """Return the values of the template."""
        return {
            "label": self.label,
            "verdict": self.verdict,
            "words": self.words(),
            "duration": f"{number(self.verdict.get('duration_s'))} s",
            "not_required": self.not_required(),
            "properties": self.property_lines(),
            "facts": facts(self.verdict),
            "timing": timing_lines(self.verdict.get("timing") or {}),
            "counts": self.verdict.get("status_counts") or {},
            "links": self.verdict.get("links") or (),
            "events": self.event_lines(),
            "left_out": self.record.events.left_out,
            "configuration": json.dumps(self.configuration, indent=2, ensure_ascii=False),
            "versions": self.versions,
        }

    def words(self) -> str:
        """Return what stands against the run, fallbacks first; empty if nothing does."""
        said = str(self.verdict.get("words", ""))
        against = said.removeprefix(str(self.verdict.get("verdict"))).removeprefix(": ")
        return against if not against.startswith("violated but not required") else ""

    def not_required(self) -> list[str]:
        """Return the properties that are violated, but not required of the run."""
        return [line.name for line in self.property_lines() if line.outcome == "violated" and line.required == "no"]

    def property_lines(self) -> list[PropertyLine]:
        """Return the properties of the verdict."""
        outcomes = {True: "holds", False: "violated", None: "unknown"}
        return [
            PropertyLine(
                name=name,
                outcome=outcomes[entry.get("holds")],
                required="yes" if entry.get("required", True) else "no",
                worst=number(entry.get("worst")),
                at=time_text(entry.get("at_s")),
                at_s=None if entry.get("at_s") is None else entry["at_s"] + self.offset_s,
                requirement=entry.get("requirement", "").replace(" -", f" {MINUS}"),
            )
            for name, entry in (self.verdict.get("properties") or {}).items()
        ]

    def event_lines(self) -> list[EventLine]:
        """Return all that happened, in order of time."""
        return [
            EventLine(
                at_s=round(event.at_s + self.offset_s, 6),
                time=time_text(event.at_s),
                severity=event.severity,
                source="" if event.source == REVIEW else event.source,
                text=event.text,
            )
            for event in run_events(self.record)
        ]


def time_text(at_s: float | None) -> str:
    """Return a plant time as text; a dash for none."""
    return "–" if at_s is None else signed(f"{at_s:.3f} s")


def facts(verdict: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return metrics of a run by their names."""
    final = verdict.get("final_x")
    gaps = verdict.get("gaps") or {}
    missing = ", ".join(f"{topic} {count}" for topic, count in gaps.items() if count)
    return [
        ("duration", f"{number(verdict.get('duration_s'))} s"),
        ("lowest h, between samples too", number(verdict.get("h_min"))),
        ("lowest power margin, between samples too", f"{number(verdict.get('power_margin_min'))} W"),
        ("lowest tank energy", f"{number(verdict.get('tank_min_j'))} J"),
        ("largest ‖u‖", number(verdict.get("u_norm_max"))),
        ("final x", "unknown" if final is None else f"({', '.join(number(value) for value in final)})"),
        ("filter ticks", number(verdict.get("ticks"), 9)),
        ("commands of the operator", (verdict.get("commands") or {}).get("text", "unknown")),
        ("steps skipped", number(verdict.get("steps_skipped"), 9)),
        ("messages missing in the log", missing or ("none" if gaps else "unknown")),
    ]


def timing_lines(timing: Mapping[str, Any]) -> list[TimingLine]:
    """Return the percentiles of a run's timing."""
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
