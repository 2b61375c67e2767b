"""The paper's robot: a point mass in the plane with linear damping (paper, equation 25)."""

import casadi as ca

from passafe.models.braking import braking_condition, stopping_segment
from passafe.models.robot import Robot
from passafe.ranges import require_not_negative, require_positive
from passafe.system import System


def damped_point(*, sigma: float = 1.0, gamma_1: float = 0.0) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u, y = x₂, all in the plane.

    Positions have relative degree 2, velocities 1. The fail-safe is u = −K x₂ with K = max(γ₁ − σ, 0); what it keeps,
    and why, is in ``passafe.models.braking``, with κ = σ + K.

    Args:
        sigma: Damping σ, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive("damped point sigma", sigma, "1/s")
    require_not_negative("damped point gamma_1", gamma_1, "1/s")
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    position, velocity = x[:2], x[2:]
    rate = max(gamma_1, sigma)
    return Robot(
        system=System(x=x, u=u, f=ca.vertcat(velocity, -sigma * velocity + u), y=velocity),
        position=position,
        velocity=velocity,
        points=1,
        fail_safe=-(rate - sigma) * velocity,
        fail_safe_gain=rate - sigma,
        stopping_hull=stopping_segment(position, velocity, rate),
        fail_safe_condition=braking_condition(rate),
    )
