"""Pendulums that hang or stand, driven at their joint."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, product, speed_at_most
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, log_uniform, one_of

GRAVITY = 9.81


def pendulum(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw ml²φ̈ = ∓mgl·sin φ − ml²dφ̇ + u, hanging or standing at φ = 0."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
    angle, rate = x[0], x[1]
    length, mass, friction = log_uniform(rng, 0.1, 2.0), log_uniform(rng, 0.1, 3.0), rng.uniform(0.0, 1.0)
    hangs = 1.0 if chance(rng, 0.5) else -1.0
    inertia = mass * length**2
    weight = hangs * mass * GRAVITY * length * ca.sin(angle)
    limit = rng.uniform(0.4, 1.2)
    kind = one_of(rng, ("sides", "product", "side"))
    offers: list[BarrierOffer] = list(between("angle", angle, limit, 2))
    if kind == "product":
        offers = [product("angle", angle, limit, 2)]
    elif kind == "side":
        offers = offers[:1]
    if chance(rng, 0.5):
        offers.append(speed_at_most("speed", rate, rng.uniform(1.0, 4.0)))
    low, high = symmetric(1.3, 3.0)
    return GeneratedPlant(
        system=System(x=x, u=u, f=ca.vertcat(rate, (u - weight) / inertia - friction * rate), y=rate),
        storage=inertia * rate**2 / 2 + mass * GRAVITY * length * hangs * (1 - ca.cos(angle)),
        fail_safe=weight - inertia * max(timing.braking_rate_per_s - friction, 0.0) * rate,
        feedback=ca.SX.zeros(1),
        barriers=tuple(offers),
        low=low,
        high=high,
        input_scale=(mass * GRAVITY * length + inertia,),
        natural_rate_per_s=float(np.sqrt(GRAVITY / length)),
    )
