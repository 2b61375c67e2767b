"""The outcome of a run, and the one sentence for it: of terminal, report and page alike."""

from collections.abc import Mapping
from typing import Final, Literal, TypeAlias

from passafe_services.tools.review.property import Property

EVIDENCE: Final = ("complete", "links-reconciled")
"""Properties of the log rather than of the robot: without them a run neither holds nor fails."""

AGREEMENT: Final = (
    *("states-agree", "inputs-agree", "predictions-agree"),
    *("decisions-agree", "ticks-agree", "tank-agrees", "scenario-agrees"),
)
"""Properties that what processes report agrees with what is derived anew; without a log there is nothing to compare."""

Outcome: TypeAlias = Literal["holds", "fails", "unproven"]


def decide(properties: Mapping[str, Property]) -> Outcome:
    """Return the outcome of a run from its properties; see ``Verdict.verdict``."""
    required = {name: entry for name, entry in properties.items() if entry.required}
    if any(entry.holds is False for name, entry in required.items() if name not in EVIDENCE):
        return "fails"
    return "holds" if all(entry.holds for entry in required.values()) else "unproven"


def in_words(properties: Mapping[str, Property]) -> str:
    """Return the outcome with what stands against it, in the order of the properties.

    Fallbacks come first in that order, and with them what says that a run is worth little although nothing was hit.
    """
    against = [_reason(name, entry) for name, entry in properties.items() if _is_against(entry)]
    notes = [entry.note for entry in properties.values() if entry.note and not _is_against(entry)]
    unasked = [
        name for name, entry in properties.items() if entry.holds is False and not entry.required and not entry.note
    ]
    if unasked:
        notes.append(f"violated but not required: {', '.join(unasked)}")
    said = "; ".join((*against, *notes))
    outcome = decide(properties)
    return f"{outcome}: {said}" if said else outcome


def _is_against(entry: Property) -> bool:
    return entry.required and entry.holds is not True


def _reason(name: str, entry: Property) -> str:
    if entry.note:
        return entry.note
    if entry.holds is None:
        return f"{name} is unknown"
    worst = "" if entry.worst is None else f": {entry.worst:.3g}"
    at = "" if entry.at_s is None else f" at {entry.at_s:.3f} s"
    allowed = f", allowed {entry.allowed}" if worst and entry.allowed else ""
    return f"not {name}{worst}{at}{allowed}"
