"""The fail-safe of a lagged point when its inputs are held: gains for which every wall is kept, tried one by one.

Along the normal of a wall, h and its derivatives obey ḧ = a, ȧ = (u − w)/T − σa with w = a + σḣ, so that the held law
u = −G ḣ + F w is a linear map from sample to sample. It keeps h ≥ 0 from every state with h, ψ₁, ψ₂ ≥ 0 if and only if
it does so from the three extreme rays of that cone, on which one of them is 1 and the others are 0: any other state is
a sum of these. So three trajectories decide, whatever the gains; they are followed until they rest.

Tried are the law in continuous time, which suffices where a pole is the robot's own, then laws that place the poles of
the sampled map at e^{−κ₁dt}, e^{−κ₂dt}, with κ₁, κ₂ ever larger: a held input acts late.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import exp
from typing import Final

import numpy as np

from passafe.numerics.fixed_order import exponential, least_squares, product, spectral_radius
from passafe.numerics.workspace import Array

FASTER: Final = (1.0, 1.02, 1.05, 1.1, 1.2, 1.35, 1.5, 2.0, 3.0, 5.0)
"""Factors on the poles, tried in turn."""

INSTANTS: Final = 16
"""Instants of each period at which h is looked at."""

AT_ONCE: Final = 4096
"""Periods that are followed at once, in the end; at first one, then ever more."""

RESTS: Final = 1e-9
"""Velocity and force, relative to those at first, at which the trajectory counts as resting."""

SLOWEST: Final = 1 - 1e-6
"""Share of velocity and force left after a period beyond which the robot counts as one that does not come to rest."""

MISSED: Final = 1e-9
"""By how much h may fall below zero, relative to the largest h of its trajectory: rounding."""


@dataclass(frozen=True, kw_only=True, slots=True)
class LaggedGains:
    """u = −G·velocity + F·force.

    Attributes:
        on_velocity: G, 1/s.
        on_force: F.
    """

    on_velocity: float
    on_force: float


@dataclass(frozen=True, kw_only=True, slots=True)
class HeldLaggedBraking:
    """A lagged point and the barriers that its fail-safe is to keep.

    Attributes:
        sigma: Damping σ, 1/s.
        lag_s: T, s.
        gamma_1: Gain of the first class-K function, 1/s.
        gamma_2: Gain of the second one, 1/s.
        dt_s: How long each input is held, s, positive.
    """

    sigma: float
    lag_s: float
    gamma_1: float
    gamma_2: float
    dt_s: float

    def placed(self, k_1: float, k_2: float) -> LaggedGains:
        """Return the gains with which velocity and force decay with e^{−κ₁dt} and e^{−κ₂dt} (Ackermann's formula)."""
        step = _flow(self.sigma, self.lag_s, self.dt_s)
        A, B = step[1:3, 1:3], step[1:3, 3]
        z_1, z_2 = exp(-k_1 * self.dt_s), exp(-k_2 * self.dt_s)
        wanted = product(A, A) - (z_1 + z_2) * A + z_1 * z_2 * np.eye(2)
        last = least_squares(np.stack((B, product(A, B))), np.array([0.0, 1.0]))
        row = product(last, wanted)
        return LaggedGains(on_velocity=float(row[0]), on_force=-float(row[1]))

    def keeps(self, gains: LaggedGains) -> bool:
        """Return whether h ≥ 0 from every state with h, ψ₁, ψ₂ ≥ 0, between samples too."""
        step = self._closed(gains, self.dt_s)
        if spectral_radius(step[1:, 1:]) > SLOWEST:
            return False
        heights, jump = self._h_within(gains), step
        state = self._rays()
        first, largest = np.abs(state[1:]).max(axis=0), np.zeros(3)
        while (np.abs(state[1:]).max(axis=0) > RESTS * first).any():
            h = product(heights, state)
            largest = np.maximum(largest, np.abs(h).max(axis=0))
            if (h.min(axis=0) < -MISSED * largest).any():
                return False
            state = product(jump, state)
            if len(heights) < AT_ONCE * INSTANTS:
                heights, jump = np.concatenate((heights, product(heights, jump))), product(jump, jump)
        return True

    def _rays(self) -> Array:
        """Return (h, ḣ, w) on the three extreme rays, as columns: where h, ψ₁ and ψ₂ in turn are one."""
        g_1, g_2, sigma = self.gamma_1, max(self.gamma_1, self.gamma_2), self.sigma
        return np.array([[1.0, 0.0, 0.0], [-g_1, 1.0, 0.0], [g_1 * (g_1 - sigma), sigma - g_1 - g_2, 1.0]])

    def _closed(self, gains: LaggedGains, seconds: float) -> Array:
        """Return the map of (h, ḣ, w) that begins with a sample of the law and lasts for some seconds."""
        flow, law = _flow(self.sigma, self.lag_s, seconds), np.array([0.0, -gains.on_velocity, gains.on_force])
        closed: Array = flow[:3, :3] + np.outer(flow[:3, 3], law)
        return closed

    def _h_within(self, gains: LaggedGains) -> Array:
        """Return the rows that give h at instants of a period from the sample at its beginning."""
        instants = np.linspace(0.0, self.dt_s, INSTANTS, endpoint=False)
        return np.stack([self._closed(gains, float(t))[0] for t in instants])


@lru_cache(maxsize=64)
def _flow(sigma: float, lag_s: float, seconds: float) -> Array:
    """Return the flow of (h, ḣ, w, u) with u held."""
    M = np.zeros((4, 4))
    M[0, 1], M[1, 1:3] = 1.0, (-sigma, 1.0)
    M[2, 2:] = -1 / lag_s, 1 / lag_s
    return exponential(M * seconds)


@lru_cache(maxsize=64)  # a scenario's robot is built by many of its parts
def held_gains(braking: HeldLaggedBraking, k_1: float, k_2: float, continuous: LaggedGains) -> tuple[LaggedGains, bool]:
    """Return the first gains that keep every wall, and whether there are any; else a law that at least stops.

    Args:
        braking: Robot and barriers.
        k_1: κ₁ of the law in continuous time, 1/s.
        k_2: κ₂ of it, 1/s.
        continuous: Its gains.
    """
    faster = (braking.placed(factor * k_1, factor * k_2) for factor in FASTER)
    for gains in (continuous, *faster):
        if braking.keeps(gains):
            return gains, True
    return braking.placed(k_1, k_2), False
