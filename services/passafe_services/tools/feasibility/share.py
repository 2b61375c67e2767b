"""Shares of random states with confidence intervals."""

from collections.abc import Sequence
from math import sqrt
from statistics import NormalDist
from typing import Final, Self

import numpy as np

from passafe.numerics.workspace import Array
from passafe_services.tools.runs.record import SweepRecord

QUANTILE: Final = NormalDist().inv_cdf(0.975)
"""Of the standard normal distribution, for an interval of 95 %."""


class Share(SweepRecord):
    """Share of random states.

    Attributes:
        kept: Number of states counted.
        of: Number of all states.
        low: Lower end of the 95 % Wilson interval (Wilson 1927).
        high: Its upper end.
    """

    kept: int
    of: int
    low: float
    high: float

    @classmethod
    def counted(cls, kept: int, of: int) -> Self:
        """Return the share of a count; without states, its interval is [0, 1]."""
        if of == 0:
            return cls(kept=0, of=0, low=0.0, high=1.0)
        square = QUANTILE**2
        middle = (2 * kept + square) / (2 * (of + square))
        half = QUANTILE * sqrt(4 * kept * (of - kept) / of + square) / (2 * (of + square))
        low, high = 0.0 if kept == 0 else middle - half, 1.0 if kept == of else middle + half
        return cls(kept=kept, of=of, low=low, high=high)


def random_states(low: Sequence[float], high: Sequence[float], count: int, seed: int) -> Array:
    """Return states drawn uniformly from a box, shape (n, count).

    Args:
        low: Lower corner, n numbers.
        high: Upper corner, n numbers.
        count: Number of states.
        seed: Seed of the generator.
    """
    return np.random.default_rng(seed).uniform(low, high, (count, len(low))).T
