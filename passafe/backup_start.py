"""The barriers that the fail-safe law keeps from the start, followed until the robot rests."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from passafe.backup_rollout import LONGEST, BackupRollout
from passafe.course import Course
from passafe.design import Law
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity

HELPLESS: Final = "the gatekeeper does nothing from here: start slower, or where the law keeps every barrier"
UNSTEADY: Final = (
    "a shorter hold_s, or a law with gains below 1/hold_s: the gatekeeper relies on it where inputs are lost"
)


def backup_findings(core: SafetyPassivityFilter, x0: Sequence[float]) -> Iterator[Finding]:
    """Yield what the fail-safe law alone keeps from the start, where there are barriers and inputs are sampled.

    A gatekeeper keeps every barrier for ever where this law does (docs/theory.md, theorem 3), and does nothing
    elsewhere.

    Args:
        core: The filter.
        x0: Start, n numbers.
    """
    design = core.design
    if not _is_known(core):
        return
    course = _course(core, x0)
    is_lasting = not course.is_safe or _is_kept_late(core, x0)
    found = _found(course, design.dt_s)
    if not is_lasting:
        found = (
            f"keeps every barrier if sent every period, but is not known to if held for {design.held_s:g} s at a time"
        )
    advice = ""
    if design.gatekeeper:
        advice = HELPLESS if not course.is_safe else "" if is_lasting else UNSTEADY
    yield Finding(
        severity=Severity.WARNING if advice else Severity.NOTE,
        topic="fail-safe",
        subject="from the start",
        found=found,
        advice=advice,
    )


def is_kept_from(core: SafetyPassivityFilter, x0: Sequence[float]) -> bool:
    """Return whether the fail-safe law is proven to keep every barrier from a start, lost inputs or not.

    Args:
        core: The filter.
        x0: Start, n numbers.
    """
    return _is_known(core) and _course(core, x0).is_safe and _is_kept_late(core, x0)


def _is_kept_late(core: SafetyPassivityFilter, x0: Sequence[float]) -> bool:
    """Return whether that is so if each of the law's inputs is held as long as it may be."""
    held = core.design.held_periods
    return held == 1 or _course(core, x0, held).is_safe


def _is_known(core: SafetyPassivityFilter) -> bool:
    return bool(core.derivation.barriers.chains) and core.design.law is Law.SAMPLED


def _course(core: SafetyPassivityFilter, x0: Sequence[float], law_held: int = 1) -> Course:
    rollout = BackupRollout(core.design, core.derivation.barriers.chains)
    return rollout.course(np.array(x0, dtype=float), 0.0, np.array(core.design.limits.centre), 0, law_held=law_held)


def _found(course: Course, dt_s: float) -> str:
    if course.is_safe:
        return f"keeps every barrier until the robot rests, h ≥ {course.lowest:.3g}: a gatekeeper would do so for ever"
    if course.lowest < 0:
        return f"h is {course.lowest:.3g} after {course.lowest_at * dt_s:.3g} s"
    if not course.comes_to_rest:
        return f"keeps every barrier for {LONGEST * dt_s:.3g} s, in which the robot does not come to rest"
    return "h ≥ 0 at every sample, but not known to be between them"
