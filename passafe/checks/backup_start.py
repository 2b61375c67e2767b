"""The barriers that the fail-safe law alone keeps from the start and other states, followed until the robot rests."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from passafe.courses.backup_rollout import LONGEST
from passafe.courses.course import Course
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity

HELPLESS: Final = "the gatekeeper does nothing from here: start slower, or where the law keeps every barrier"
UNSTEADY: Final = "a shorter hold_s, or a law with gains below 1/hold_s: the filter relies on it where inputs are lost"


class FailSafeCourses:
    """Courses of a filter's fail-safe law, from any state."""

    def __init__(self, core: SafetyPassivityFilter) -> None:
        """Take the filter's own rollout.

        Args:
            core: The filter.
        """
        self._rollout = core.rollout
        self._u, self._held_periods = np.array(core.design.limits.centre), core.design.held_periods

    def course(self, x: Sequence[float], law_held: int = 1) -> Course | None:
        """Return the course from a state; ``None`` if there is none.

        Args:
            x: The state, n numbers.
            law_held: Number of periods for which each input of the law is held.
        """
        if self._rollout is None:
            return None
        return self._rollout.course(np.array(x, dtype=float), 0.0, self._u, 0, law_held=law_held)

    def is_kept(self, x: Sequence[float]) -> bool:
        """Return whether every barrier is proven to be kept from a state."""
        course = self.course(x)
        return course is not None and course.is_safe

    def is_kept_late(self, x: Sequence[float]) -> bool:
        """Return whether that is so if each of the law's inputs is held as long as it may be."""
        course = self.course(x, self._held_periods)
        return course is not None and course.is_safe


def backup_findings(core: SafetyPassivityFilter, x0: Sequence[float]) -> Iterator[Finding]:
    """Yield what the fail-safe law alone keeps from the start, where there are barriers and inputs are sampled.

    A gatekeeper keeps every barrier for ever where this law does (docs/theory.md, theorem 3), and does nothing
    elsewhere.

    Args:
        core: The filter.
        x0: Start, n numbers.
    """
    courses = FailSafeCourses(core)
    course = courses.course(x0)
    if course is None:
        return
    is_lasting = not course.is_safe or courses.is_kept_late(x0)
    advice = ""
    if core.design.gatekeeper:
        advice = HELPLESS if not course.is_safe else "" if is_lasting else UNSTEADY
    yield Finding(
        severity=Severity.WARNING if advice else Severity.NOTE,
        topic="fail-safe",
        subject="from the start",
        found=_found(course, core.design.dt_s) if is_lasting else unsteady(core),
        advice=advice,
    )


def is_kept_from(core: SafetyPassivityFilter, x0: Sequence[float]) -> bool:
    """Return whether the fail-safe law is proven to keep every barrier from a start, lost inputs or not.

    Args:
        core: The filter.
        x0: Start, n numbers.
    """
    courses = FailSafeCourses(core)
    return courses.is_kept(x0) and courses.is_kept_late(x0)


def unsteady(core: SafetyPassivityFilter) -> str:
    """Return, as part of a sentence, that the law keeps every barrier unless its inputs are lost."""
    held = f"held for {core.design.held_s:g} s at a time"
    return f"keeps every barrier if sent every period, but is not known to if {held}"


def _found(course: Course, dt_s: float) -> str:
    if course.is_safe:
        return f"keeps every barrier until the robot rests, h ≥ {course.lowest:.3g}: a gatekeeper would do so for ever"
    if course.lowest < 0:
        return f"h is {course.lowest:.3g} after {course.lowest_at * dt_s:.3g} s"
    if not course.comes_to_rest:
        return f"keeps every barrier for {LONGEST * dt_s:.3g} s, in which the robot does not come to rest"
    return "h ≥ 0 at every sample, but not known to be between them"
