"""The barriers that the fail-safe law keeps from the start, followed until the robot rests."""

from collections.abc import Iterator, Sequence

import numpy as np

from passafe.backup_rollout import LONGEST, BackupRollout
from passafe.course import Course
from passafe.design import Law
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity


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
    is_helpless = design.gatekeeper and not course.is_safe
    yield Finding(
        severity=Severity.WARNING if is_helpless else Severity.NOTE,
        topic="fail-safe",
        subject="from the start",
        found=_found(course, design.dt_s),
        advice="the gatekeeper does nothing from here: start slower, or where the law keeps every barrier"
        if is_helpless
        else "",
    )


def is_kept_from(core: SafetyPassivityFilter, x0: Sequence[float]) -> bool:
    """Return whether the fail-safe law is proven to keep every barrier from a start until the robot rests.

    Args:
        core: The filter.
        x0: Start, n numbers.
    """
    return _is_known(core) and _course(core, x0).is_safe


def _is_known(core: SafetyPassivityFilter) -> bool:
    return bool(core.derivation.barriers.chains) and core.design.law is Law.SAMPLED


def _course(core: SafetyPassivityFilter, x0: Sequence[float]) -> Course:
    rollout = BackupRollout(core.design, core.derivation.barriers.chains)
    return rollout.course(np.array(x0, dtype=float), 0.0, np.array(core.design.limits.centre), 0)


def _found(course: Course, dt_s: float) -> str:
    if course.is_safe:
        return f"keeps every barrier until the robot rests, h ≥ {course.lowest:.3g}: a gatekeeper would do so for ever"
    if course.lowest < 0:
        return f"h is {course.lowest:.3g} after {course.lowest_at * dt_s:.3g} s"
    if not course.comes_to_rest:
        return f"keeps every barrier for {LONGEST * dt_s:.3g} s, in which the robot does not come to rest"
    return "h ≥ 0 at every sample, but not known to be between them"
