"""Points whose actuator is not affine in the input: clipped, smoothly saturated, or quadratic."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, speed_at_most
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, log_uniform, one_of, some_of

GRAVITY = 9.81


def saturated(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw v̇ = −σv + F·s(u/F) with s a clip, tanh or z/√(1 + z²)."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
    force, sigma = log_uniform(rng, 2.0, 50.0), log_uniform(rng, 0.05, 3.0)
    kind = one_of(rng, ("clip", "tanh", "root"))
    acting = {
        "clip": ca.fmin(ca.fmax(u, -force), force),
        "tanh": force * ca.tanh(u / force),
        "root": u / ca.sqrt(1 + (u / force) ** 2),
    }[kind]
    return _point(
        rng, x, u, acting - sigma * x[1], fail_safe=-max(timing.braking_rate_per_s - sigma, 0.0) * x[1], scale=force
    )


def quadratic(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw v̇ = cu² − g, v̇ = −σv + cu|u|, or v̇ = u − c·v·√(v² + ε): propellers, and drag of a fluid."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
    rate, coefficient = timing.braking_rate_per_s, log_uniform(rng, 0.2, 2.0)
    kind = one_of(rng, ("propeller", "two-sided", "drag"))
    if kind == "propeller":
        thrust = ca.sqrt(ca.fmax(GRAVITY - rate * x[1], 0) / coefficient)
        scale = float(np.sqrt(GRAVITY / coefficient))
        return _point(rng, x, u, coefficient * u**2 - GRAVITY, fail_safe=thrust, scale=2 * scale)
    if kind == "two-sided":
        wanted = -rate * x[1] / coefficient
        softened = wanted / ca.sqrt(ca.sqrt(wanted**2 + 1e-2))  # about the signed root, without its steep place
        return _point(rng, x, u, coefficient * u * ca.fabs(u) - 0.2 * x[1], fail_safe=softened, scale=4.0)
    drag = coefficient * x[1] * ca.sqrt(x[1] ** 2 + 1e-3)
    return _point(rng, x, u, u - drag, fail_safe=-rate * x[1], scale=6.0)


def _point(
    rng: np.random.Generator, x: ca.SX, u: ca.SX, acceleration: ca.SX, *, fail_safe: ca.SX, scale: float
) -> GeneratedPlant:
    offers: list[BarrierOffer] = list(some_of(rng, between("place", x[0], rng.uniform(0.8, 2.0), 2), 2))
    if chance(rng, 0.4):
        offers.append(speed_at_most("speed", x[1], rng.uniform(0.8, 2.5)))
    low, high = symmetric(2.2, 2.0)
    return GeneratedPlant(
        system=System(x=x, u=u, f=ca.vertcat(x[1], acceleration), y=x[1]),
        storage=x[1] ** 2 / 2,
        fail_safe=fail_safe,
        feedback=ca.SX.zeros(1),
        barriers=tuple(offers),
        low=low,
        high=high,
        input_scale=(scale,),
        natural_rate_per_s=2.0,
    )
