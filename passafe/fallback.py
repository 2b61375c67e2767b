"""The choice among inputs where the hard rows cannot be kept with their margins: no answer is worse than braking.

Every candidate is held for as long as the plant may hold it, then the backup law follows; the backup law at once is the
course that all are compared with. The answer of the program is sent if on its course no barrier is lost earlier than on
the backup's, nor by more; another input only if its course is better than that of the best so far.
"""

from collections.abc import Sequence
from math import ceil

from passafe.backup_rollout import BackupRollout
from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign
from passafe.workspace import Array

SLACK_PERIODS = 1e-9
"""Rounding of the number of periods that a hold takes."""


class Fallback:
    """Compares inputs by the courses that they lead to."""

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain]) -> None:
        """Derive the rollout.

        Args:
            design: The filter's.
            chains: Chains of the enforced barriers.
        """
        self._rollout = BackupRollout(design, chains)
        self._held_periods = max(1, ceil(design.held_s / design.dt_s - SLACK_PERIODS))

    def best(self, x: Array, t_s: float, u: Array, candidates: Sequence[Array]) -> int | None:
        """Return the place of the best candidate, or ``None`` where the backup law's input is better than all.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input before, shape (m,).
            candidates: Inputs within the limits, each of shape (m,), in the order of preference; the first is the
                program's answer.
        """
        backup = self._rollout.course(x, t_s, u, 0)
        best, place = backup, None
        for k, candidate in enumerate(candidates):
            course = self._rollout.course(x, t_s, candidate, self._held_periods)
            is_preferred = k == 0 and course.is_no_worse_than(backup)
            if is_preferred or (course.is_no_worse_than(best) and not best.is_no_worse_than(course)):
                best, place = course, k
        return place

    def is_backed(self, x: Array, t_s: float, u: Array) -> bool:
        """Return whether every barrier is proven to be kept if the backup law follows this input, whenever it does.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input to be held, shape (m,).
        """
        return all(self._rollout.course(x, t_s, u, held).is_safe for held in {1, self._held_periods})

    def keeps(self, x: Array, t_s: float, u: Array) -> bool:
        """Return whether every barrier is proven to be kept by the backup law from here on.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: Input before, shape (m,).
        """
        return self._rollout.course(x, t_s, u, 0).is_safe
