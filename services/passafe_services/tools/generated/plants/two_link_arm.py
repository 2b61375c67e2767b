"""Arms with two links in the vertical plane, their masses at the ends of the links, driven by torques."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, log_uniform, some_of

GRAVITY = 9.81


def two_link_arm(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw M(q)q̈ + c(q, q̇) + g(q) + dq̇ = u; q = 0 is the arm hanging straight down."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    q, rates = x[:2], x[2:]
    m1, m2, l1, l2 = (log_uniform(rng, low, high) for low, high in ((0.3, 4.0), (0.2, 3.0), (0.2, 1.0), (0.2, 1.0)))
    coupling, own = m2 * l1 * l2, m2 * l2**2
    a, b = (m1 + m2) * l1**2 + own + 2 * coupling * ca.cos(q[1]), own + coupling * ca.cos(q[1])
    inertia = ca.vertcat(ca.horzcat(a, b), ca.horzcat(b, ca.SX(own)))
    swing = coupling * ca.sin(q[1])
    turning = ca.vertcat(-swing * (2 * rates[0] * rates[1] + rates[1] ** 2), swing * rates[0] ** 2)
    heights = [-l1 * ca.cos(q[0]), -l1 * ca.cos(q[0]) - l2 * ca.cos(q[0] + q[1])]
    potential = GRAVITY * (m1 * heights[0] + m2 * heights[1])
    weight, friction = ca.gradient(potential, q), rng.uniform(0.0, 1.0)
    inverse = ca.vertcat(ca.horzcat(ca.SX(own), -b), ca.horzcat(-b, a)) / (a * own - b**2)
    groups: list[tuple[BarrierOffer, ...]] = [
        between("joint-0", q[0], rng.uniform(0.5, 1.5), 2),
        between("joint-1", q[1], rng.uniform(0.5, 1.5), 2),
        between("speed-0", rates[0], rng.uniform(1.0, 3.0), 1),
        between("speed-1", rates[1], rng.uniform(1.0, 3.0), 1),
        (BarrierOffer(name="hand", h=-heights[1] - rng.uniform(0.1, 0.6) * (l1 + l2), degree=2),),
    ]
    low, high = symmetric(1.2, 1.2, 1.5, 1.5)
    return GeneratedPlant(
        system=System(x=x, u=u, f=ca.vertcat(rates, inverse @ (u - turning - weight - friction * rates)), y=rates),
        storage=ca.dot(rates, inertia @ rates) / 2 + potential,
        fail_safe=weight - timing.braking_rate_per_s * (inertia @ rates),
        feedback=weight if chance(rng, 0.5) else ca.SX.zeros(2),
        barriers=tuple(offer for group in some_of(rng, groups, 3) for offer in group),
        low=low,
        high=high,
        input_scale=((m1 + m2) * GRAVITY * l1 + own, m2 * GRAVITY * l2 + own),
        natural_rate_per_s=float(np.sqrt(GRAVITY / l1)),
    )
