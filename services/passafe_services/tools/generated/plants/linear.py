"""Linear plants: stable and unstable oscillators, and points whose damping or lag is stiff for the period."""

import casadi as ca
import numpy as np
from scipy.linalg import qr

from passafe.models.damped_point import damped_point
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, in_the_plane, speed_at_most
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, log_uniform

STIFFNESS = (0.5, 50.0)
"""T·L of stiff plants: the longest hold times the fastest rate."""

SHARE_TURNED = 0.3
"""Share of oscillators whose states are turned, so that every derivative mixes all of them."""


def stable(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw q̈ = −Kq − Dq̇ + u, K ≥ 0 and D > 0."""
    return _oscillator(rng, timing, sign=1.0)


def unstable(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw the same with springs that push away from the origin."""
    return _oscillator(rng, timing, sign=-1.0)


def stiff(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw a damped or a lagged point with T·L up to 50."""
    fast = log_uniform(rng, *STIFFNESS) / timing.held_s
    braking = timing.braking_rate_per_s
    if chance(rng, 0.5):
        robot, degree, force = damped_point(sigma=fast, gamma_1=min(braking, fast)), 2, fast
    else:
        sigma = log_uniform(rng, 0.2, 5.0)
        # Poles no faster than the plant's own: a faster one is more than a held law could place.
        robot, degree, force = lagged_point(sigma=sigma, lag_s=1 / fast, gamma_1=min(sigma, fast)), 3, 1.0
    offers = list(in_the_plane(rng, robot.position, degree))
    if chance(rng, 0.4):
        offers.append(speed_at_most("speed", robot.velocity, rng.uniform(0.5, 2.0), degree - 1))
    return _stiff_plant(robot, tuple(offers), force)


def _stiff_plant(robot: Robot, offers: tuple[BarrierOffer, ...], force: float) -> GeneratedPlant:
    system = robot.system
    low, high = symmetric(2.5, 2.5, 1.0, 1.0, *(2.0,) * (system.n - 4))
    return GeneratedPlant(
        system=system,
        storage=ca.sumsqr(robot.velocity) / 2,
        fail_safe=robot.fail_safe,
        feedback=ca.SX.zeros(2),
        barriers=offers,
        low=low,
        high=high,
        input_scale=(max(force, 2.0),) * 2,
        natural_rate_per_s=force,
    )


def _oscillator(rng: np.random.Generator, timing: DesignTiming, *, sign: float) -> GeneratedPlant:
    axes = 2 if chance(rng, 0.4) else 1
    x, u = ca.SX.sym("x", 2 * axes), ca.SX.sym("u", axes)
    turned = qr(rng.standard_normal((2 * axes, 2 * axes)))[0] if chance(rng, SHARE_TURNED) else np.eye(2 * axes)
    back = ca.SX(ca.DM(turned.T)) @ x
    q, rate = back[:axes], back[axes:]
    root = rng.standard_normal((axes, axes))
    spring = sign * log_uniform(rng, 0.1, 30.0) * (root @ root.T / axes + 0.1 * np.eye(axes))
    damping = log_uniform(rng, 0.05, 5.0)
    pull = -ca.DM(spring) @ q - damping * rate
    f = ca.DM(turned) @ ca.vertcat(rate, pull + u)
    offers = list(in_the_plane(rng, q, 2)) if axes > 1 else list(between("q", q[0], rng.uniform(0.8, 2.0), 2))
    if chance(rng, 0.4):
        offers.append(speed_at_most("speed", rate, rng.uniform(0.8, 3.0)))
    low, high = symmetric(*(2.0,) * (2 * axes))
    return GeneratedPlant(
        system=System(x=x, u=u, f=f, y=rate),
        storage=ca.sumsqr(rate) / 2 + (ca.dot(q, ca.DM(spring) @ q) / 2 if sign > 0 else 0),
        fail_safe=ca.DM(spring) @ q - max(timing.braking_rate_per_s - damping, 0.0) * rate,
        feedback=ca.SX.zeros(axes),
        barriers=tuple(offers),
        low=low,
        high=high,
        input_scale=(2.0 + float(np.abs(spring).max()),) * axes,
        natural_rate_per_s=float(np.sqrt(np.abs(spring).max())),
    )
