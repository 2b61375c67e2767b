"""Kinematic bicycles, whose steering angle is an input, through its tangent, or a state."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, in_the_plane
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance

SHARPEST = 0.6
"""Steering angle, rad."""


def bicycle(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw ṗ = v·e(θ), θ̇ = v·tan(δ)/L, v̇ = a − σv, with δ an input or δ̇ an input."""
    is_steered_by_rate = chance(rng, 0.5)
    x, u = ca.SX.sym("x", 5 if is_steered_by_rate else 4), ca.SX.sym("u", 2)
    ahead, speed = ca.vertcat(ca.cos(x[2]), ca.sin(x[2])), x[3]
    steering, base, sigma = x[4] if is_steered_by_rate else u[1], rng.uniform(0.3, 2.0), rng.uniform(0.05, 1.0)
    f = ca.vertcat(speed * ahead, speed * ca.tan(steering) / base, u[0] - sigma * speed)
    offers = list(in_the_plane(rng, x[:2], 2))
    if chance(rng, 0.5):
        offers += between("speed", speed, rng.uniform(0.8, 2.0), 1)
    centring = ca.SX(0)
    widths = [2.5, 2.5, np.pi, 1.5]
    if is_steered_by_rate:
        f, centring = ca.vertcat(f, u[1]), -timing.braking_rate_per_s * steering
        offers += between("steering", steering, SHARPEST, 1)
        widths.append(0.9 * SHARPEST)
    low, high = symmetric(*widths)
    return GeneratedPlant(
        system=System(x=x, u=u, f=f, y=ca.vertcat(speed, 0)),
        storage=speed**2 / 2,
        fail_safe=ca.vertcat(-max(timing.braking_rate_per_s - sigma, 0.0) * speed, centring),
        feedback=ca.SX.zeros(2),
        barriers=tuple(offers),
        low=low,
        high=high,
        input_scale=(3.0, 1.0 if is_steered_by_rate else SHARPEST),
        natural_rate_per_s=2.0,
        largest_input=None if is_steered_by_rate else (1e3, SHARPEST),
    )
