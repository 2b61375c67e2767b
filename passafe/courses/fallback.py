"""The choice among inputs where the hard rows cannot be kept with their margins: no answer is worse than braking.

Every candidate is held for one period or for as long as the plant may hold it, whichever is worse, then the backup
law follows; the backup law at once is the course that all are compared with. The answer of the program is sent if on
its course no barrier is lost earlier than on the backup's, nor by more; another input only if its course is better
than that of the best so far; of these, a course that is proven to keep every barrier goes before one that is not.
After every period the rest of the chosen course is the backup's course from there: so where no input is lost, a run
of such ticks keeps barriers for as long as the backup law would from its first tick on.

Where all of these lose a barrier, inputs between the backup's and each candidate are tried as well: an input that keeps
the rows at the sample may be far too long for the period, and a part of it brakes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from passafe.barrier_chain import BarrierChain
from passafe.courses.backup_rollout import LONGEST, BackupRollout
from passafe.courses.course import CHUNK, KEPT, Course
from passafe.design import FilterDesign
from passafe.numerics.workspace import Array, Compiler, interpreted

PARTS: Final = (0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Parts of the way from the backup's input to a candidate that are tried."""

SURE: Final = 2
"""Candidates, the first ones, of which a proven course is looked for even where one that is not keeps every barrier."""


@dataclass(frozen=True, kw_only=True, slots=True)
class BestCourse:
    """The best of some inputs.

    Attributes:
        place: Place of the candidate; ``None`` for the backup law's input.
        is_safe: Whether every barrier is proven to be kept on its course, until the robot rests.
    """

    place: int | None
    is_safe: bool


class Fallback:
    """Compares inputs by the courses that they lead to.

    Attributes:
        rollout: Rolls the courses out.
        has_gatekeeper: Whether the design has one.
    """

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain], compiler: Compiler = interpreted) -> None:
        """Derive the rollout.

        Args:
            design: The filter's.
            chains: Chains of the enforced barriers.
            compiler: Compiles the rollout.
        """
        self.rollout = BackupRollout(design, chains, compiler)
        self.has_gatekeeper = design.gatekeeper
        self._held_periods = design.held_periods

    def best(self, x: Array, t_s: float, u: Array, candidates: Sequence[Array]) -> BestCourse:
        """Return the best of the candidates and the backup law's input.

        Courses are compared over twice the time in which the backup's gets lowest; one that is better is then followed
        to its end, and counts if it is no worse there either. A course that is proven to be safe is preferred to one
        that is not. Once one is, or a candidate keeps every barrier, the rest are not looked at. The answer's is tried
        first: where it is proven there is none better.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input before, shape (m,).
            candidates: Inputs within the limits, each of shape (m,), in the order of preference, at least one: the
                first is the program's answer.
        """
        answer = candidates[0]
        if self.is_backed(x, t_s, answer) and (not self.has_gatekeeper or self.is_lasting(x, t_s, u, answer)):
            return BestCourse(place=0, is_safe=True)
        best, place = self.rollout.course(x, t_s, u, 0), None
        is_late = self.has_gatekeeper and best.is_safe and self.keeps_late(x, t_s, u)
        until = min(2 * best.lowest_at + CHUNK, LONGEST)
        for k, candidate in enumerate(candidates):
            if k and (best.is_safe or (k >= SURE and place is not None and best.is_no_worse_than(KEPT))):
                break
            course = self._preferred(x, t_s, candidate, best, until, k)
            if course is not None and (not is_late or self.is_backed_late(x, t_s, candidate)):
                best, place = course, k
        return BestCourse(place=place, is_safe=best.is_safe)

    def is_backed(self, x: Array, t_s: float, u: Array) -> bool:
        """Return whether every barrier is proven to be kept if the backup law follows this input, whenever it does.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input to be held, shape (m,).
        """
        return all(self._is_safe(x, t_s, u, held) for held in sorted({1, self._held_periods}))

    def is_lasting(self, x: Array, t_s: float, u: Array, answer: Array) -> bool:
        """Return whether an input that is backed stays so where inputs are lost, or the law alone is not known to.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input before, shape (m,).
            answer: Input to be held, shape (m,).
        """
        return self._held_periods == 1 or self.is_backed_late(x, t_s, answer) or not self.keeps_late(x, t_s, u)

    def is_backed_late(self, x: Array, t_s: float, u: Array) -> bool:
        """Return whether that is so even if this input and each of the law's are held as long as they may be.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input to be held, shape (m,).
        """
        return self._is_safe(x, t_s, u, self._held_periods, late=True)

    def keeps_late(self, x: Array, t_s: float, u: Array) -> bool:
        """Return whether ``keeps`` holds even if each input of the law is held as long as it may be.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input before, shape (m,).
        """
        return self._held_periods > 1 and self._is_safe(x, t_s, u, 0, late=True)

    def keeps(self, x: Array, t_s: float, u: Array) -> bool:
        """Return whether every barrier is proven to be kept by the backup law from here on.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input before, shape (m,).
        """
        return self._is_safe(x, t_s, u, 0)

    def _is_safe(self, x: Array, t_s: float, u: Array, held_periods: int, *, late: bool = False) -> bool:
        law_held = self._held_periods if late else 1
        return self.rollout.course(x, t_s, u, held_periods, to_prove=True, law_held=law_held).is_safe

    def _preferred(self, x: Array, t_s: float, u: Array, best: Course, until: int, k: int) -> Course | None:
        """Return the course of candidate k if it takes the place of the best so far; at equal ones the first does."""
        course = self._held(x, t_s, u, best, until)
        if not course.is_no_worse_than(best) or (k >= SURE and best.is_no_worse_than(course)):
            return None
        course = self._held(x, t_s, u, best)
        if not course.is_no_worse_than(best):
            return None
        if best.is_safe and not course.is_safe and (self.has_gatekeeper or course.is_bounded(best)):
            return None
        return course if k == 0 or course.is_safe or not best.is_no_worse_than(course) else None

    def _held(self, x: Array, t_s: float, u: Array, than: Course, until: int = LONGEST) -> Course:
        """Return the course under an input for one period or the longest hold, whichever is worse."""
        course = self.rollout.course(x, t_s, u, 1, than, until)
        if self._held_periods == 1 or not course.is_no_worse_than(than):
            return course
        return course.or_worse(self.rollout.course(x, t_s, u, self._held_periods, than, until))


def between(backup: Array, candidates: Sequence[Array]) -> list[Array]:
    """Return inputs on the way from the backup law's to each candidate; within the limits, for these are convex.

    Args:
        backup: The backup law's input, within the limits, shape (m,).
        candidates: Inputs within the limits, each of shape (m,).
    """
    return [backup + part * (candidate - backup) for candidate in candidates for part in PARTS]
