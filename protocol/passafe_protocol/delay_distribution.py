"""Delay distributions: the quantile function of each, and a sampler of delays.

The random part of a delay is jitter_s·q(U), U uniform in (0, 1), q one of ``STANDARD``, all but the uniform one with
mean 0 and standard deviation 1. The shapes are those of netem's tables (iproute2, ``netem/pareto.c`` and
``netem/paretonormal.c``), but not clipped at four standard deviations, and with the requested standard deviation.
"""

from collections.abc import Callable
from math import pow, sqrt  # noqa: A004 - this one returns a float, whatever the exponent
from statistics import NormalDist
from typing import Final, TypeAlias

from passafe_protocol.link_settings import MAX_DELAY_S, LinkSettings

Quantile: TypeAlias = Callable[[float], float]

LONGEST_NS: Final = round(2e9 * MAX_DELAY_S)
"""Longest delay, whatever the tail of the distribution; with the rate it bounds the messages in flight."""

_NS_PER_S: Final = 1e9
_LEAST: Final = 2.0**-53
_normal: Final = NormalDist().inv_cdf

PARETO_SHAPE: Final = 3.0
_PARETO_SCALE: Final = 2.0 / sqrt(3.0)  # of a Pareto variable of shape 3, mean 3/2, variance 3/4

PARETO_NORMAL_SIGMA: Final = 0.937753856874
"""Standard deviation of (Φ⁻¹(U) + 3·P(U))/4, P the standard Pareto quantile function."""


def uniform(u: float) -> float:
    """Return the quantile of the uniform distribution on [−1, 1): 2u − 1."""
    return 2.0 * u - 1.0


def normal(u: float) -> float:
    """Return the standard normal quantile, Φ⁻¹(u)."""
    return _normal(_inside(u))


def pareto(u: float) -> float:
    """Return the quantile of a Pareto distribution of shape 3, mean 0, deviation 1: ((1 − u)^(−1/3) − 3/2)·2/√3."""
    return (pow(1.0 - _inside(u), -1.0 / PARETO_SHAPE) - 1.5) * _PARETO_SCALE


def pareto_normal(u: float) -> float:
    """Return a quarter of the normal and three quarters of the Pareto quantile, scaled to standard deviation 1."""
    return (normal(u) + 3.0 * pareto(u)) / (4.0 * PARETO_NORMAL_SIGMA)


STANDARD: Final[dict[str, Quantile]] = {
    "uniform": uniform,
    "normal": normal,
    "pareto": pareto,
    "pareto-normal": pareto_normal,
}
"""Quantile function of each distribution that is scaled by the jitter."""


def histogram(quantiles_s: tuple[float, ...]) -> Quantile:
    """Return the quantile function, s, that interpolates quantiles at equal steps of probability linearly."""
    steps = len(quantiles_s) - 1

    def quantile(u: float) -> float:
        position = u * steps
        i = min(int(position), steps - 1)
        return quantiles_s[i] + (position - i) * (quantiles_s[i + 1] - quantiles_s[i])

    return quantile


def delay_sampler(settings: LinkSettings, uniform_source: Callable[[], float]) -> Callable[[], int]:
    """Return a function that draws one delay, ns, clipped to [0, ``LONGEST_NS``].

    Args:
        settings: Settings of the link.
        uniform_source: Draws from [0, 1]; called once per delay, never if the delay is constant.
    """
    base_ns = settings.delay_s * _NS_PER_S
    if settings.distribution == "histogram":
        quantile, scale_ns = histogram(settings.quantiles_s), _NS_PER_S
    elif settings.jitter_s:
        quantile, scale_ns = STANDARD[settings.distribution], settings.jitter_s * _NS_PER_S
    else:
        constant_ns = round(base_ns)
        return lambda: constant_ns

    def sample() -> int:
        delay_ns = base_ns + scale_ns * quantile(uniform_source())
        return 0 if delay_ns < 0.0 else LONGEST_NS if delay_ns > LONGEST_NS else round(delay_ns)

    return sample


def _inside(u: float) -> float:
    """Return the nearest number that has a finite quantile."""
    return min(max(u, _LEAST), 1.0 - _LEAST)
