"""A point mass in the plane with quadratic drag: the nonlinear sibling of the paper's robot."""

import casadi as ca

from passafe.models.braking import braking_robot
from passafe.models.robot import Robot
from passafe.ranges import require_not_negative


def drag_point(*, sigma: float = 0.5, drag: float = 0.5, gamma_1: float = 0.0) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ − c‖x₂‖x₂ + u, y = x₂, all in the plane.

    Positions have relative degree 2, velocities 1. The fail-safe is u = −K x₂ with K = max(γ₁ − σ, 0); what it keeps,
    and why, is in ``passafe.models.braking``, with κ = σ + K: drag acts along the velocity, so the path is a straight
    segment no longer than without it.

    Args:
        sigma: Linear damping σ, 1/s, positive.
        drag: Quadratic drag c, 1/m, not negative.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_not_negative("drag point drag", drag, "1/m")

    def acceleration(velocity: ca.SX, u: ca.SX) -> ca.SX:
        # The norm's slope is undefined at rest; this one differs from it by less than 1e-9 m/s and is smooth.
        speed = ca.sqrt(ca.sumsqr(velocity) + 1e-18)
        return -(sigma + drag * speed) * velocity + u

    return braking_robot("drag point", axes=2, points=1, sigma=sigma, gamma_1=gamma_1, acceleration=acceleration)
