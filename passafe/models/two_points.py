"""Two of the paper's robots in one plane, driven at once: for the distance between robots."""

import casadi as ca

from passafe.models.braking import braking_condition, stopping_segment
from passafe.models.robot import Robot
from passafe.ranges import require_not_negative, require_positive
from passafe.system import System


def two_points(*, sigma: float = 1.0, gamma_1: float = 0.0) -> Robot:
    """Return two points with ṗ = v, v̇ = −σv + u each; x = (p₁, p₂, v₁, v₂), u = (u₁, u₂), y = (v₁, v₂).

    Positions have relative degree 2, velocities 1. The fail-safe is u = −K(v₁, v₂) with K = max(γ₁ − σ, 0); what it
    keeps, and why, is in ``passafe.models.braking``, with κ = σ + K: both points brake alike, so all four coordinates
    together move on a straight segment, and the separation is convex in them.

    Args:
        sigma: Damping σ of both, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive("two points sigma", sigma, "1/s")
    require_not_negative("two points gamma_1", gamma_1, "1/s")
    x, u = ca.SX.sym("x", 8), ca.SX.sym("u", 4)
    position, velocity = x[:4], x[4:]
    rate = max(gamma_1, sigma)
    return Robot(
        system=System(x=x, u=u, f=ca.vertcat(velocity, -sigma * velocity + u), y=velocity),
        position=position,
        velocity=velocity,
        points=2,
        fail_safe=-(rate - sigma) * velocity,
        fail_safe_gain=rate - sigma,
        stopping_hull=stopping_segment(position, velocity, rate),
        fail_safe_condition=braking_condition(rate),
    )
