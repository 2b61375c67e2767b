"""Planar quadrotors from 30 g to 2 kg, with the thrust beyond their weight and the torque as inputs."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between, speed_at_most
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, log_uniform, some_of

GRAVITY = 9.81


def quadrotor(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw mp̈ = (mg + F)·e(θ) − mg·e_z, Iθ̈ = τ."""
    x, u = ca.SX.sym("x", 6), ca.SX.sym("u", 2)
    mass, arm = log_uniform(rng, 0.03, 2.0), log_uniform(rng, 0.04, 0.3)
    inertia = mass * arm**2 / 2
    tilt, speed, turning = x[2], x[3:5], x[5]
    up = ca.vertcat(-ca.sin(tilt), ca.cos(tilt))
    rise = (GRAVITY + u[0] / mass) * up - ca.vertcat(0, GRAVITY)
    rate = timing.braking_rate_per_s
    hover = ca.vertcat(-mass * rate * speed[1], -inertia * (rate**2 * tilt / 2 + rate * turning))
    groups = [
        between("height", x[1], rng.uniform(0.8, 2.0), 2),
        between("tilt", tilt, rng.uniform(0.3, 0.8), 2),
        between("climb", speed[1], rng.uniform(0.5, 2.0), 1),
        (speed_at_most("turning", turning, rng.uniform(2.0, 6.0)),),
    ]
    low, high = symmetric(2.0, 2.0, 0.5, 1.0, 1.0, 2.0)
    return GeneratedPlant(
        system=System(
            x=x, u=u, f=ca.vertcat(speed, turning, rise, u[1] / inertia), y=ca.vertcat(ca.dot(up, speed), turning)
        ),
        storage=mass * ca.sumsqr(speed) / 2 + inertia * turning**2 / 2,
        fail_safe=hover,
        feedback=hover / 4 if chance(rng, 0.5) else ca.SX.zeros(2),
        barriers=tuple(offer for group in some_of(rng, groups, 3) for offer in group),
        low=low,
        high=high,
        input_scale=(mass * GRAVITY / 2, inertia * 20.0),
        natural_rate_per_s=rate,
    )
