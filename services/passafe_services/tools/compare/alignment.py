"""Alignment of runs: the plant time that counts as the same moment in each."""

from typing import Final

from passafe_protocol.messages import Event, FilterStatus, FilterTick, PlantPhase, PlantState

from passafe_services.tools.compare.errors import AlignmentError
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S

EVENT: Final = "event:"

KINDS: Final = (
    "stop",
    "fail-safe",
    "break",
    *(status.name.lower().replace("_", "-") for status in FilterStatus),
    "text=WORDS",
)
"""Kinds of events; the last one is an event whose text contains these words."""

ALLOWED: Final = f"start, first-input, or event:KIND with one of {', '.join(KINDS)}"


def origin_s(log: RunLog, align: str) -> float:
    """Return the plant time in a run that counts as zero, s.

    Args:
        log: Its log.
        align: ``start``: plant time 0. ``first-input``: the first tick in which the operator asks for something.
            ``event:KIND``: the first event of that kind.

    Raises:
        AlignmentError: Another word, or no such event in the log.
    """
    if align == "start":
        return 0.0
    if align == "first-input":
        found = next((tick.body.effective_plant_ns for tick in log.of(FilterTick) if any(tick.body.u_h)), None)
    elif align.startswith(EVENT):
        found = _event_ns(log, align.removeprefix(EVENT))
    else:
        raise AlignmentError("--align", repr(align), ALLOWED)
    if found is None:
        raise AlignmentError("--align", f"{align}, of which {log.path} has none", ALLOWED)
    return found / NS_PER_S


def _event_ns(log: RunLog, kind: str) -> int | None:
    """Return the plant time of the first event of a kind, ns; ``None`` without one."""
    states = log.of(PlantState)
    if kind == "stop":
        return next((state.body.plant_ns for state in states if state.body.stop), None)
    if kind == "fail-safe":
        return next((state.body.plant_ns for state in states if state.body.phase is PlantPhase.FAIL_SAFE), None)
    if kind == "break":
        return next((state.body.sequence_break_ns for state in states if state.body.sequence_break_ns >= 0), None)
    if kind.startswith("text="):
        words = kind.removeprefix("text=")
        wall_ns = [event.header.wall_ns for event in log.of(Event) if words in event.body.text]
        return next((s.body.plant_ns for s in states if wall_ns and s.header.wall_ns >= min(wall_ns)), None)
    name = kind.upper().replace("-", "_")
    if name not in FilterStatus.__members__:
        raise AlignmentError("--align", repr(EVENT + kind), ALLOWED)
    status = FilterStatus[name]
    return next((tick.body.effective_plant_ns for tick in log.of(FilterTick) if tick.body.status is status), None)
