"""Unicycles: driven by speed and turning rate, or by acceleration and turning rate."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, in_the_plane
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance


def unicycle(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw one of the two."""
    return _kinematic(rng) if chance(rng, 0.5) else _dynamic(rng, timing)


def _kinematic(rng: np.random.Generator) -> GeneratedPlant:
    """Return ṗ = v·e(θ), θ̇ = ω, with the point ahead of the axle kept safe."""
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u", 2)
    ahead = ca.vertcat(ca.cos(x[2]), ca.sin(x[2]))
    low, high = symmetric(2.5, 2.5, np.pi)
    return GeneratedPlant(
        system=System(x=x, u=u, f=ca.vertcat(u[0] * ahead, u[1]), y=ca.vertcat(ca.dot(x[:2], ahead), 0)),
        storage=ca.sumsqr(x[:2]) / 2,
        fail_safe=ca.SX.zeros(2),
        feedback=ca.SX.zeros(2),
        barriers=in_the_plane(rng, x[:2] + rng.uniform(0.05, 0.4) * ahead, 1),
        low=low,
        high=high,
        input_scale=(1.0, 2.0),
        natural_rate_per_s=2.0,
    )


def _dynamic(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Return ṗ = v·e(θ), θ̇ = ω, v̇ = a − σv."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    ahead, speed = ca.vertcat(ca.cos(x[2]), ca.sin(x[2])), x[3]
    sigma = rng.uniform(0.1, 2.0)
    offers = list(in_the_plane(rng, x[:2], 2))
    if chance(rng, 0.5):
        offers += between("speed", speed, rng.uniform(0.8, 2.0), 1)
    low, high = symmetric(2.5, 2.5, np.pi, 1.5)
    return GeneratedPlant(
        system=System(x=x, u=u, f=ca.vertcat(speed * ahead, u[1], u[0] - sigma * speed), y=ca.vertcat(speed, 0)),
        storage=speed**2 / 2,
        fail_safe=ca.vertcat(-max(timing.braking_rate_per_s - sigma, 0.0) * speed, 0),
        feedback=ca.SX.zeros(2),
        barriers=tuple(offers),
        low=low,
        high=high,
        input_scale=(3.0, 2.0),
        natural_rate_per_s=2.0,
    )
