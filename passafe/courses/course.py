"""A course of the robot: what is kept on it, and when it is no worse than another."""

from dataclasses import dataclass
from math import inf
from typing import Final

CHUNK: Final = 32
"""Periods that are rolled out at a time."""

EQUAL: Final = 1e-6
"""Difference of two violations, relative to them, that counts as none."""

ROUNDING: Final = 1e-9
"""Value below zero that counts as zero where two courses are compared."""

LOOSE: Final = 1e3
"""Distance of a lower bound from the estimate, relative to the size of h, from which on it says nothing."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Course:
    """Outcome of one rollout.

    Attributes:
        kept_periods: Periods from the first on in which every barrier is kept; infinite where it is to the end.
        lowest: Least of all h, by estimate between samples.
        proven: Lower bound of all h, where ``is_proven``.
        soon: ``lowest`` until ``CHUNK`` periods after a barrier is lost, to compare courses without end.
        lowest_at: Period in which it is.
        is_proven: Whether the bounds between samples and the integration are known all along.
        comes_to_rest: Whether the robot came to rest, or where no barrier falls any more, before the rollout ended.
    """

    kept_periods: float
    lowest: float
    proven: float
    soon: float
    lowest_at: int
    is_proven: bool
    comes_to_rest: bool

    @property
    def is_safe(self) -> bool:
        """True if every barrier is proven to be kept until the robot rests."""
        return self.is_proven and self.comes_to_rest and self.proven >= 0.0

    def is_bounded(self, other: "Course") -> bool:
        """Return whether its lower bound says anything: near a norm's singular point it is missing, or a huge number.

        Args:
            other: Another course from the same state, which shows how large h is.
        """
        return self.is_proven and self.lowest - self.proven <= LOOSE * (abs(self.lowest) + abs(other.lowest))

    def is_no_worse_than(self, other: "Course") -> bool:
        """Return whether no barrier is lost earlier than on another course, nor by more than rounding and ``EQUAL``.

        Where neither course has an end, what counts is by how much soon after the loss.
        """
        if self.kept_periods < other.kept_periods:
            return False
        if self.lowest == other.lowest == -inf:
            return self.soon >= _deepest(other.soon)
        return self.lowest >= _deepest(other.lowest)

    def or_worse(self, other: "Course") -> "Course":
        """Return what is certain of a course that may be this one or another."""
        lower = min(self, other, key=lambda course: course.lowest)
        return Course(
            kept_periods=min(self.kept_periods, other.kept_periods),
            lowest=lower.lowest,
            proven=min(self.proven, other.proven),
            soon=min(self.soon, other.soon),
            lowest_at=lower.lowest_at,
            is_proven=self.is_proven and other.is_proven,
            comes_to_rest=self.comes_to_rest and other.comes_to_rest,
        )


def _deepest(lowest: float) -> float:
    return min(lowest, 0.0) * (1 + EQUAL) - ROUNDING


KEPT: Final = Course(
    kept_periods=inf, lowest=0.0, proven=0.0, soon=0.0, lowest_at=0, is_proven=True, comes_to_rest=True
)
"""A course on which every barrier is kept."""
