"""Remnant: the part of a person's response that is not a linear function of the observation."""

from math import exp, pi, sqrt
from typing import Final

import numpy as np

BLOCK: Final = 512
"""Normal numbers drawn at a time; single draws would cost ten times as much each."""


class Remnant:
    """Relative observation errors: independent first-order noise of a given density, one step per glance.

    Levison, Baron & Kleinman (1969) found remnant to be independent white noise on each displayed quantity y, with a
    density that is a fixed share ρ of the variance of y per rad/s; 0.01 or −20 dB for a foveal display. So y(1 + n) is
    observed, n with autocovariance πρδ(t) at low frequencies. White noise has infinite variance, hence n is
    first-order noise, n ← φn + √(1 − φ²)σw, φ = e^{−ωg}, held for a glance g, with the same density at zero:

        σ² = πρ (1 − φ) / (g (1 + φ)).
    """

    def __init__(self, *, ratio: float, bandwidth_rad_per_s: float, glance_s: float, count: int, seed: int) -> None:
        """Start at zero.

        Args:
            ratio: ρ, s/rad; 0 for none.
            bandwidth_rad_per_s: Bandwidth ω.
            glance_s: g, time of one step, s.
            count: Numbers per step.
            seed: Seed of the generator.
        """
        self._keep = phi = exp(-bandwidth_rad_per_s * glance_s)
        self.deviation = sqrt(pi * ratio * (1 - phi) / (glance_s * (1 + phi)))
        """σ, standard deviation of each number in the long run."""
        self._add = sqrt(1 - phi * phi) * self.deviation
        self._n = [0.0] * count
        self._rng = np.random.default_rng(seed)
        self._drawn: list[float] = []

    def step(self) -> list[float]:
        """Return the errors at the next glance, in the same list every time."""
        errors, add = self._n, self._add
        if not add:
            return errors
        if len(self._drawn) < len(errors):
            self._drawn = self._rng.standard_normal(BLOCK * len(errors)).tolist()
        keep, draw = self._keep, self._drawn.pop
        for i, error in enumerate(errors):
            errors[i] = keep * error + add * draw()
        return errors
