"""Shares of random states, with what a sample of that size can say about them."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict
from scipy.stats import binomtest

from passafe.workspace import Array


class Share(BaseModel):
    """A share of random states.

    Attributes:
        kept: How many.
        of: Of how many.
        low: Lower end of the 95 % Wilson interval (Wilson 1927).
        high: Its upper end.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kept: int
    of: int
    low: float
    high: float

    @classmethod
    def counted(cls, kept: int, of: int) -> Self:
        """Return the share of a count; of nothing, it may be anything from 0 to 1."""
        if of == 0:
            return cls(kept=0, of=0, low=0.0, high=1.0)
        interval = binomtest(kept, of).proportion_ci(confidence_level=0.95, method="wilson")
        return cls(kept=kept, of=of, low=float(interval.low), high=float(interval.high))


def random_states(low: Sequence[float], high: Sequence[float], count: int, seed: int) -> Array:
    """Return states drawn evenly from a box, shape (n, count).

    Args:
        low: Its least corner, n numbers.
        high: Its largest, n numbers.
        count: How many.
        seed: Decides all of them.
    """
    return np.random.default_rng(seed).uniform(low, high, (count, len(low))).T
