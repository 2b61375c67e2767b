"""Braking by u = −K v with each input held for a while: which gains neither overshoot nor stop too late.

v̇ = −σv + u, u = −K v(0) held for dt. With a = e^{−σdt}, q = (1 − a)/σ and ℓ = dt/(1 − a) − 1/σ (dt/2 for small dt):

    v(dt) = (a − Kq) v(0),    p(dt) − p(0) = q(1 − Kℓ) v(0).

* The velocity does not turn round if Kq ≤ a, which is (1 − e^{−σdt})(1 + K/σ) ≤ 1, for small dt κ·dt ≤ 1 with
  κ = σ + K. Beyond it the robot overshoots, and for κ·dt > 2 it goes ever faster.
* If it does not, the path is a straight segment, in all no longer than v(0)/γ exactly if that holds of one period and
  the velocity left after it, γ q(1 − Kℓ) ≤ 1 − (a − Kq): K ≥ (γ − σ)/(1 + γℓ).
"""

from dataclasses import dataclass
from math import exp, expm1, inf, log1p
from typing import Final

from passafe.arguments.ranges import require_not_negative, require_positive

SERIES_BELOW: Final = 1e-3
"""σ·dt below which ℓ is taken from its series: its closed form cancels there."""


@dataclass(frozen=True, kw_only=True, slots=True)
class HeldBraking:
    """Braking with inputs that are each held for ``dt_s``.

    Attributes:
        sigma: Linear damping σ, 1/s, positive.
        dt_s: How long each input is held, s; 0 for a law that is followed at every instant.
    """

    sigma: float
    dt_s: float

    def __post_init__(self) -> None:
        """Refuse numbers for which nothing of this is defined."""
        require_positive("sigma", self.sigma, "1/s")
        require_not_negative("dt_s", self.dt_s, "s")

    @property
    def reach_s(self) -> float:
        """Return q = (1 − e^{−σdt})/σ: way in one period without braking, for each unit of speed, s."""
        return -expm1(-self.sigma * self.dt_s) / self.sigma

    @property
    def lag_s(self) -> float:
        """ℓ: how much later a held input brakes than one that acts at once would, s."""
        z = self.sigma * self.dt_s
        if z < SERIES_BELOW:
            return self.dt_s * (0.5 + z / 12)
        return self.dt_s / -expm1(-z) - 1 / self.sigma

    @property
    def largest_gain(self) -> float:
        """Largest K without overshoot, e^{−σdt}/q, 1/s: the robot stands after one period."""
        return exp(-self.sigma * self.dt_s) / self.reach_s if self.dt_s else inf

    def least_gain(self, gamma_1: float) -> float:
        """Return the least K, 1/s, with which the way is no longer than v/γ₁: max((γ₁ − σ)/(1 + γ₁ℓ), 0)."""
        return max((gamma_1 - self.sigma) / (1 + gamma_1 * self.lag_s), 0.0)

    def kept_gain(self, gain: float) -> float:
        """Return the largest γ₁, 1/s, for which K suffices: (σ + K)/(1 − Kℓ)."""
        return (self.sigma + gain) / (1 - gain * self.lag_s)


def longest_hold_s(sigma: float, gain: float) -> float:
    """Return the longest time for which u = −K v may be held without overshoot, ln(1 + σ/K)/σ, s."""
    return log1p(sigma / gain) / sigma if gain else inf
