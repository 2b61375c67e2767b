"""Cars that follow a leader, which is a state of the plant or a moving barrier."""

import casadi as ca
import numpy as np

from passafe.system import System
from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant
from passafe_services.tools.generated.random_numbers import chance

MASS_KG = 1650.0


def car_following(rng: np.random.Generator, timing: DesignTiming) -> GeneratedPlant:
    """Draw v̇ = (u − f₀ − f₁v − f₂v²)/m behind a leader whose speed returns to v₀, or is v₀ + a·sin ωt."""
    is_state = chance(rng, 0.5)
    x, u, t = ca.SX.sym("x", 3 if is_state else 2), ca.SX.sym("u", 1), ca.SX.sym("t")
    speed, cruise = x[1], rng.uniform(10.0, 25.0)
    drag = 0.1 + 5.0 * speed + 0.25 * speed**2
    push = (u - drag) / MASS_KG
    if is_state:
        gap, back = x[0], rng.uniform(0.05, 0.5)
        f = ca.vertcat(x[2] - speed, push, back * (cruise - x[2]))
        low, high = [5.0, 5.0, 10.0], [100.0, 30.0, 25.0]
    else:
        swing, pace = rng.uniform(0.0, 2.0), rng.uniform(0.2, 1.0)
        gap = 60.0 + cruise * t + swing * (1 - ca.cos(pace * t)) / pace - x[0]
        f = ca.vertcat(speed, push)
        low, high = [-40.0, 5.0], [55.0, 30.0]
    if chance(rng, 0.5):
        offers = [BarrierOffer(name="headway", h=gap - rng.uniform(1.0, 2.0) * speed, degree=1)]
    else:
        offers = [BarrierOffer(name="gap", h=gap - rng.uniform(2.0, 8.0), degree=2)]
    if chance(rng, 0.4):
        offers.append(BarrierOffer(name="speed", h=rng.uniform(25.0, 35.0) - speed, degree=1))
    return GeneratedPlant(
        system=System(x=x, u=u, f=f, y=speed, t=t),
        storage=MASS_KG * speed**2 / 2,
        fail_safe=-MASS_KG * timing.braking_rate_per_s * speed,
        feedback=ca.SX.zeros(1),
        barriers=tuple(offers),
        low=tuple(low),
        high=tuple(high),
        input_scale=(MASS_KG * 3.0,),
        natural_rate_per_s=0.5,
    )
