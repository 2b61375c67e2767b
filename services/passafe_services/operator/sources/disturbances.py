"""Open-loop disturbances as operators: random steps and a chirp."""

from bisect import bisect_right
from math import cos, exp, log, pi, sin, tau
from typing import ClassVar, Final

import numpy as np

from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock

LOWEST_HZ: Final = 0.1
HIGHEST_HZ: Final = 50.0
SWEEP_S: Final = 10.0
"""Time of a chirp from its lowest to its highest frequency; then it restarts."""


class RandomSteps:
    """Steps of a Poisson process, one per second on average, uniform in a box.

    The steps depend on the seed only, not on the times of the commands.
    """

    device: ClassVar[str] = "adversary"
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    def __init__(self, rng: np.random.Generator, inputs: int, strength: float) -> None:
        """Draw the first step.

        Args:
            rng: Random generator of the steps.
            inputs: m.
            strength: Largest |u_h| in each axis, units of u.
        """
        self._rng, self._inputs, self._strength = rng, inputs, strength
        self._ends_s: list[float] = []
        self._commands: list[Command] = []
        self._begin_s = self._end_s = 0.0
        self._now = self._after(0.0)

    def command(self, t_s: float) -> Command:
        """Return the command at plant time ``t_s`` ≥ 0."""
        if not self._begin_s <= t_s < self._end_s:
            self._now = self._after(t_s)
        return self._now

    def _after(self, t_s: float) -> Command:
        """Draw steps until one ends after ``t_s``, and return the one at ``t_s``."""
        last_s = self._ends_s[-1] if self._ends_s else 0.0
        while last_s <= t_s:
            last_s += float(self._rng.exponential(1.0))
            u_h = self._rng.uniform(-self._strength, self._strength, self._inputs).tolist()
            self._ends_s.append(last_s)
            self._commands.append(Command(tuple(u_h), (0.0,) * self._inputs, True))
        index = bisect_right(self._ends_s, t_s)
        self._begin_s = self._ends_s[index - 1] if index else 0.0
        self._end_s = self._ends_s[index]
        return self._commands[index]


class Chirp:
    """Exponential chirp: u_h = A cos(2πc + φ), ċ = f₀e^{rt} from 0.1 to 50 Hz within 10 s, repeated."""

    device: ClassVar[str] = "adversary"
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    def __init__(self, rng: np.random.Generator, inputs: int, strength: float) -> None:
        """Draw amplitude, at least a quarter of ``strength``, and phase of every axis; arguments as ``RandomSteps``."""
        amplitudes = rng.uniform(strength / 4, strength, inputs).tolist()
        phases = rng.uniform(0, tau, inputs).tolist()
        self._axes = list(zip(amplitudes, phases, strict=True))
        self._rate_per_s = log(HIGHEST_HZ / LOWEST_HZ) / SWEEP_S

    def command(self, t_s: float) -> Command:
        """Return the command at plant time ``t_s`` ≥ 0."""
        frequency_hz = LOWEST_HZ * exp(self._rate_per_s * (t_s % SWEEP_S))
        cycles = (frequency_hz - LOWEST_HZ) / self._rate_per_s
        u_h, rate = [], []
        for amplitude, phase in self._axes:
            angle = tau * cycles + phase
            u_h.append(amplitude * cos(angle))
            rate.append(-amplitude * tau * frequency_hz * sin(angle))
        return Command(tuple(u_h), tuple(rate), True)


def bang_bang_period_s(rng: np.random.Generator) -> float:
    """Draw a period between 20 ms and 1 s, uniform in its logarithm."""
    return exp(float(rng.uniform(log(0.02), 0.0)))


def bang_bang_sign(t_s: float, period_s: float) -> float:
    """Return the sign of a bang-bang operator at ``t_s``, 1 or −1."""
    return 1.0 if cos(2 * pi * t_s / period_s) > 0 else -1.0
