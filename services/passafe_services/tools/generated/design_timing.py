"""Rate, hold and gains of a random design: what its plant and its braking law are drawn to fit."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from passafe_services.tools.generated.random_numbers import chance, log_uniform

RATES_HZ: Final = (10.0, 2000.0)
LONGEST_HOLD_S: Final = 0.2
"""The longest that a scenario may ask for."""

GAINS_PER_S: Final = (0.5, 50.0)

SHARE_OF_FREE_GAINS: Final = 0.2
"""Share of designs whose gains are drawn without regard to the hold; those of the others are at most 0.8/T."""

BRAKING: Final = 0.5
"""Largest product of a braking rate and the period: a held law then neither overshoots nor oscillates."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DesignTiming:
    """Times and rates of one design.

    Attributes:
        dt_s: Period, s.
        hold_s: How long an input may stay in force without another, s.
        largest_gain_per_s: Of its class-K functions.
    """

    dt_s: float
    hold_s: float
    largest_gain_per_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Self:
        """Draw a period, a hold of one period or more, and a largest gain."""
        dt_s = 1 / log_uniform(rng, *RATES_HZ)
        longest_s = max(LONGEST_HOLD_S, dt_s)
        hold_s = log_uniform(rng, dt_s, longest_s) if chance(rng, 0.5) else dt_s
        least, most = GAINS_PER_S
        if not chance(rng, SHARE_OF_FREE_GAINS):
            most = min(most, max(0.8 / hold_s, 2 * least))
        return cls(dt_s=dt_s, hold_s=min(hold_s, LONGEST_HOLD_S), largest_gain_per_s=most)

    @property
    def held_s(self) -> float:
        """T: how long an input is in force at most, s."""
        return max(self.dt_s, self.hold_s)

    @property
    def braking_rate_per_s(self) -> float:
        """κ: the rate with which speeds fall under the braking law, 1/s."""
        return min(self.largest_gain_per_s, BRAKING / self.dt_s)

    def gain(self, rng: np.random.Generator) -> float:
        """Draw the gain of one class-K function, 1/s."""
        return log_uniform(rng, GAINS_PER_S[0], self.largest_gain_per_s)
