"""Plants that are other than their model in every way that a design's sets allow, followed finely by brute force."""

from collections.abc import Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.design import FilterDesign

Numbers = NDArray[np.float64]
INSTANTS = 12
"""Steps in which a period is followed; disturbance and input error may change at each."""


class AnyMembers:
    """Many members of a design's sets: corners first, then random ones."""

    def __init__(self, design: FilterDesign, count: int, rng: np.random.Generator) -> None:
        assert design.uncertainty is not None
        self._sets, self.count, self._rng = design.uncertainty, count, rng
        system = design.system
        names = [each.name for each in system.parameters]
        intervals = [self._sets.parameters.get(each.name, (each.value,) * 2) for each in system.parameters]
        low, high = np.array(intervals).reshape(-1, 2).T
        self.parameters = low[:, None] + (high - low)[:, None] * self._shares(len(names))
        self.n, self.m = system.n, system.m
        symbols = ca.vertcat(ca.SX(0, 1), *(each.symbol for each in system.parameters))
        general = ca.Function("f", [system.x, system.u, symbols], [system.general_f])
        self._f = general.map(count)

    def _shares(self, size: int) -> Numbers:
        """Return numbers from 0 to 1, shape (size, count), half of them 0 or 1."""
        shares = self._rng.uniform(size=(size, self.count))
        return np.where(self._rng.uniform(size=(1, self.count)) < 0.5, np.round(shares), shares)

    def within(self, bounds: Sequence[float], size: int) -> Numbers:
        """Return vectors within bounds of either sign, shape (size, count)."""
        return np.array(bounds or (0.0,) * size)[:, None] * (2 * self._shares(size) - 1)

    def starts(self, x: Sequence[float], x_error: Sequence[float]) -> Numbers:
        """Return true states of which x may have been measured, shape (n, count)."""
        return np.array(x)[:, None] + self.within(x_error, self.n)

    def follow(self, x: Numbers, u: Sequence[float], dt_s: float) -> list[Numbers]:
        """Return the states at all instants of a period, by Runge and Kutta's method."""
        states, h = [x], dt_s / INSTANTS
        for _ in range(INSTANTS):
            held = np.array(u)[:, None] + self.within(self._sets.input_error, self.m)
            push = self.within(self._sets.disturbance, self.n)
            x = states[-1]
            k_1 = self._rate(x, held) + push
            k_2 = self._rate(x + h / 2 * k_1, held) + push
            k_3 = self._rate(x + h / 2 * k_2, held) + push
            k_4 = self._rate(x + h * k_3, held) + push
            states.append(x + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4))
        return states

    def _rate(self, x: Numbers, u: Numbers) -> Numbers:
        return np.asarray(self._f(x, u, self.parameters).full())
