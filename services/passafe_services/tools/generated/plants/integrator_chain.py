"""Chains of one to five integrators, side by side in one or two axes."""

from math import comb

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, in_the_plane, speed_at_most
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, some_of

LONGEST = 5
LONGEST_IN_THE_PLANE = 3


def integrator_chain(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw p⁽ⁿ⁾ = u with n = 1 … 5.

    The fail-safe gives the speed n − 1 poles at −κ. V is the energy of the last integrator alone, so that every
    input is lossless, or that of a spring to the origin too, which the plant does not have.
    """
    length = int(rng.integers(1, LONGEST + 1))
    axes = 2 if length <= LONGEST_IN_THE_PLANE and chance(rng, 0.5) else 1
    x, u = ca.SX.sym("x", length * axes), ca.SX.sym("u", axes)
    level = [x[axes * j : axes * (j + 1)] for j in range(length)]
    storage = ca.sumsqr(level[-1]) / 2
    if chance(rng, 0.5):
        storage += rng.uniform(0.5, 4.0) * ca.sumsqr(level[0]) / 2
    speed = rng.uniform(0.3, 1.5)
    widths = [2.5] * axes + [speed * 2.0**j for j in range(length - 1) for _ in range(axes)]
    low, high = symmetric(*widths)
    return GeneratedPlant(
        system=System(x=x, u=u, f=ca.vertcat(*level[1:], u), y=level[-1]),
        storage=storage,
        fail_safe=braking_of_chain(level, timing.braking_rate_per_s),
        feedback=ca.SX.zeros(axes),
        barriers=_barriers(rng, level, speed),
        low=low,
        high=high,
        input_scale=(speed * 2.0**length,) * axes,
        natural_rate_per_s=timing.largest_gain_per_s,
    )


def braking_of_chain(level: list[ca.SX], rate_per_s: float) -> ca.SX:
    """Return the input with which (d/dt + κ)ⁿ⁻¹ of the speed is zero; zero for a single integrator.

    Args:
        level: p and its derivatives up to the last state, n of them, each of shape (k, 1).
        rate_per_s: κ, 1/s.
    """
    order = len(level) - 1
    terms = (comb(order, i) * rate_per_s ** (order - i) * level[1 + i] for i in range(order))
    return -sum(terms, ca.SX.zeros(level[0].numel()))


def _barriers(rng: np.random.Generator, level: list[ca.SX], speed: float) -> tuple[BarrierOffer, ...]:
    length, axes = len(level), level[0].numel()
    if axes > 1:
        offers = list(in_the_plane(rng, level[0], length))
    else:
        offers = list(some_of(rng, between("position", level[0][0], rng.uniform(0.8, 2.0), length), 2))
    if length > 1:
        limit = speed * rng.uniform(0.8, 2.0)
        if chance(rng, 0.5):
            offers.append(speed_at_most("speed", level[1], limit, length - 1))
        else:
            offers += between("last", level[-1][0], limit * 2.0 ** (length - 1), 1)
    return tuple(offers)
