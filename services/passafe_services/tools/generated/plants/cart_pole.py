"""Carts with a pole that hangs or stands, pushed along their track."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.barrier_offers import between
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant, symmetric
from passafe_services.tools.generated.random_numbers import chance, log_uniform, one_of

GRAVITY = 9.81


def cart_pole(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw a cart of mass M with a pole of mass m at the length l, φ = 0 where it hangs (or stands, with −g).

    (M + m·sin²φ)p̈ = u − cv + m·sin φ(lφ̇² + g·cos φ), l·φ̈ = −p̈·cos φ − g·sin φ.
    """
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 1)
    place, angle, speed, rate = ca.vertsplit(x)
    cart, pole, length = log_uniform(rng, 0.3, 5.0), log_uniform(rng, 0.05, 1.0), log_uniform(rng, 0.2, 1.5)
    friction = rng.uniform(0.0, 1.0)
    gravity = GRAVITY if chance(rng, 0.6) else -GRAVITY
    sine, cosine = ca.sin(angle), ca.cos(angle)
    pushed = u - friction * speed + pole * sine * (length * rate**2 + gravity * cosine)
    pushed = pushed / (cart + pole * sine**2)
    energy = (cart + pole) * speed**2 / 2 + pole * length * speed * rate * cosine + pole * (length * rate) ** 2 / 2
    groups: tuple[tuple[BarrierOffer, ...], ...] = (
        between("place", place, rng.uniform(0.8, 2.0), 2),
        between("speed", speed, rng.uniform(0.8, 2.0), 1),
        (*between("place", place, rng.uniform(0.8, 2.0), 2), *between("speed", speed, rng.uniform(0.8, 2.0), 1)),
        between("angle", angle, rng.uniform(0.3, 0.8), 2),
    )
    low, high = symmetric(2.2, 0.6, 1.5, 1.5)
    return GeneratedPlant(
        system=System(
            x=x, u=u, f=ca.vertcat(speed, rate, pushed, -(pushed * cosine + gravity * sine) / length), y=speed
        ),
        storage=energy + pole * gravity * length * (1 - cosine),
        fail_safe=-(cart + pole) * timing.braking_rate_per_s * speed,
        feedback=ca.SX.zeros(1),
        barriers=one_of(rng, groups),
        low=low,
        high=high,
        input_scale=(5.0 * (cart + pole),),
        natural_rate_per_s=float(np.sqrt(GRAVITY / length)),
    )
