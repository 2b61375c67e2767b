"""Record of a course as far as it has been followed."""

from math import inf, isfinite, isnan
from typing import Final

import numpy as np

from passafe.courses.course import CHUNK, Course
from passafe.numerics.stage import Stage, T
from passafe.numerics.workspace import Array

SMALL_ERROR: Final = 1e-6
"""Sum of the estimated integration errors that is neglected; by what is beyond, h counts as smaller."""

LARGEST_ERROR: Final = 1e-3
"""Sum of the estimated integration errors from which on a rollout proves nothing."""


class ChunkSummary(Stage[T], frozen=True, eq=False, gc=False):
    """Summary of what is seen in ``CHUNK`` periods.

    Attributes:
        lowest: Least h by estimate.
        bound: Its lower bound.
        error: Sum of the estimated integration errors.
        known: 1 where the bound is known in all of them.
        total: Sum of all that is seen: no number where one of them is none, which a minimum leaves out.
    """

    lowest: T
    bound: T
    error: T
    known: T
    total: T


class CourseRecord:
    """Record of a course as far as it was followed."""

    def __init__(self) -> None:
        self._periods = 0
        self._kept_periods, self._lowest, self._lowest_at = inf, inf, 0
        self._soon = self._proven = inf
        self._errors, self._is_known = 0.0, True

    def add(self, seen: Array, summary: ChunkSummary[float]) -> bool:
        """Take the next periods into account, and return whether the course has become worse by them.

        Args:
            seen: Least h by estimate, its lower bound, largest slope of an h, estimated integration error and whether
                the bound is known, shape (5, CHUNK).
            summary: The same for all of these periods.
        """
        has_errors = self._errors + summary.error > SMALL_ERROR
        is_new = summary.lowest < self._lowest or (summary.lowest < 0.0 and self._kept_periods == inf)
        if is_new or has_errors or not isfinite(summary.total):
            self._look_at(seen)
        else:
            self._proven = min(self._proven, summary.bound)
            self._errors += summary.error
            self._is_known = self._is_known and summary.known > 0
        self._periods += CHUNK
        return is_new or has_errors or not isfinite(summary.total)

    def _look_at(self, seen: Array) -> None:
        """Take every single period into account."""
        estimates, bounds, slopes, errors, known = seen
        sums = self._errors + errors.cumsum()
        if sums[-1] > SMALL_ERROR:
            lost = slopes * np.maximum(sums - SMALL_ERROR, 0.0)
            estimates, bounds = estimates - lost, bounds - lost
        place = int(estimates.argmin())  # that of the first NaN, if there is one
        lowest = _or_nothing(estimates[place])
        if not lowest >= 0.0 and self._kept_periods == inf:
            self._kept_periods = float(self._periods + np.argmin(estimates >= 0.0))
        if self._periods < self._kept_periods + CHUNK:
            self._soon = min(self._soon, lowest)
        if lowest < self._lowest:
            self._lowest, self._lowest_at = lowest, self._periods + place
        self._proven = min(self._proven, _or_nothing(bounds.min()))
        self._errors = float(sums[-1])
        self._is_known = self._is_known and bool(known.min() > 0)

    @property
    def is_kept(self) -> bool:
        """True if every barrier is proven to be kept so far."""
        return self._is_proven and self._proven >= 0.0

    @property
    def _is_proven(self) -> bool:
        return self._is_known and self._errors <= LARGEST_ERROR

    def settles(self, lowest: float) -> bool:
        """Take the rest of the course into account, and return whether every barrier is kept on it.

        Args:
            lowest: Lower bound of every h on it.
        """
        if lowest < 0:
            return False
        self._lowest, self._proven = min(self._lowest, lowest), min(self._proven, lowest)
        return True

    def course(self, *, rests: bool) -> Course:
        """Return the course so far.

        Args:
            rests: Whether the state has settled.
        """
        return Course(
            kept_periods=self._kept_periods,
            lowest=self._lowest,
            proven=self._proven,
            soon=self._soon,
            lowest_at=self._lowest_at,
            is_proven=self._is_proven,
            comes_to_rest=rests,
        )


def _or_nothing(value: float) -> float:
    """Return a value, or −∞ for no number."""
    return -inf if isnan(value) else float(value)
