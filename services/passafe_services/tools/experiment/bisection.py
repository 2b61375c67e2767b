"""The least value of an axis at which a criterion fails, from runs at a few values."""

from collections.abc import Mapping
from typing import Self

from passafe_services.tools.experiment.axes import BisectAxis
from passafe_services.tools.runs.record import SweepRecord


class Boundary(SweepRecord):
    """Interval in which a criterion first fails along an axis, as far as the values that were tried show.

    Attributes:
        holds_up_to: Largest value below the first failure that was tried; ``None`` if the lowest fails already.
        fails_from: Least value that was tried and fails; ``None`` if none does.
        monotone: Whether no value tried beyond the first failure holds again.
        tried: How many values were tried.
    """

    holds_up_to: float | None
    fails_from: float | None
    monotone: bool
    tried: int

    @classmethod
    def of(cls, holds: Mapping[float, bool]) -> Self:
        """Take it from the values that were tried and whether the criterion holds there."""
        values = sorted(holds)
        fails_from = next((value for value in values if not holds[value]), None)
        below = [value for value in values if fails_from is None or value < fails_from]
        beyond = [value for value in values if fails_from is not None and value > fails_from]
        return cls(
            holds_up_to=below[-1] if below else None,
            fails_from=fails_from,
            monotone=not any(holds[value] for value in beyond),
            tried=len(values),
        )

    def describe(self) -> str:
        """Return a short text for people."""
        if self.fails_from is None:
            text = "holds everywhere"
        elif self.holds_up_to is None:
            text = "fails from the lowest value on"
        else:
            text = f"{self.holds_up_to:.4g} to {self.fails_from:.4g}"
        return text if self.monotone else f"{text}, not monotone: holds again beyond"


def first_values(axis: BisectAxis) -> list[float]:
    """Return the values to try before anything is known: both ends and what is evenly spread between them."""
    parts = axis.scan + 1
    return [axis.low + (axis.high - axis.low) * k / parts for k in range(parts)] + [axis.high]


def next_value(axis: BisectAxis, holds: Mapping[float, bool]) -> float | None:
    """Return the value to try next for one criterion; ``None`` when the boundary is known well enough.

    Args:
        axis: The axis.
        holds: Whether the criterion holds, by value; the first values are among them.
    """
    boundary = Boundary.of(holds)
    low, high = boundary.holds_up_to, boundary.fails_from
    if low is None or high is None or high - low <= axis.widest:
        return None
    middle = (low + high) / 2
    return middle if low < middle < high else None


def most_values(axis: BisectAxis, criteria: int) -> int:
    """Return how many values may be tried for a number of criteria, at most."""
    halvings, width = 0, (axis.high - axis.low) / (axis.scan + 1)
    while width > axis.widest and halvings < 60:  # noqa: PLR2004 - a float has no more digits
        width /= 2
        halvings += 1
    return axis.scan + 2 + criteria * (halvings + 1)  # one more: widths round
