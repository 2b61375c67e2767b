"""Summaries of many runs: the spread of a metric, and how bad a value of it is."""

from collections.abc import Iterable
from math import inf, isnan
from typing import Self

import numpy as np

from passafe_services.tools.runs.record import SweepRecord


class Spread(SweepRecord):
    """The spread of a metric over runs."""

    min: float
    median: float
    max: float

    @classmethod
    def of(cls, values: Iterable[float | None]) -> Self | None:
        """Return the spread of some values, those left out that are none; ``None`` if all are."""
        known = [value for value in values if value is not None]
        if not known:
            return None
        low, high = min(known), max(known)
        return cls(min=low, median=float(np.median(known)) if np.isfinite((low, high)).all() else low, max=high)


def badness(value: float | None, *, high_is_worse: bool) -> float:
    """Return how bad the value of a metric is, the larger the worse; ∞ where a run has none, or a NaN.

    Args:
        value: The value.
        high_is_worse: Whether large values are bad, rather than small ones.
    """
    if value is None or isnan(value):
        return inf
    return value if high_is_worse else -value
