"""Correlated uniform numbers whose distribution stays exactly uniform: a Gaussian copula."""

from collections.abc import Callable
from math import erfc, pi, sin, sqrt
from typing import Final

from passafe_protocol.delay_distribution import normal

_SQRT_2: Final = sqrt(2.0)


class CorrelatedUniform:
    """Uniform numbers U_k = Φ(Z_k) of an autoregressive Gaussian sequence, Z_k = a·Z_{k−1} + √(1 − a²)·ε_k.

    Every Z_k is standard normal, so every U_k is exactly uniform, and any quantile function of it has exactly its
    distribution. (netem mixes uniform numbers, U_k = (1 − ρ)·V_k + ρ·U_{k−1}, which narrows the distribution.) The
    rank correlation of successive numbers, which quantile functions leave as it is, is ρ = (6/π)·asin(a/2)
    (Kruskal 1958), so a = 2·sin(π·ρ/6).

    Args:
        draw: Draws from [0, 1).
    """

    def __init__(self, draw: Callable[[], float]) -> None:
        self._draw = draw
        self._z: float | None = None
        self.correlate(0.0)

    def correlate(self, correlation: float) -> None:
        """Set the rank correlation of the numbers that follow, in [0, 1)."""
        self._weight = 2.0 * sin(pi * correlation / 6.0)
        self._fresh = sqrt(1.0 - self._weight**2)

    def __call__(self) -> float:
        """Return the next number."""
        fresh = normal(self._draw())
        self._z = fresh if self._z is None else self._weight * self._z + self._fresh * fresh
        return 0.5 * erfc(-self._z / _SQRT_2)
