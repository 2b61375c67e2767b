"""A point mass in the plane with quadratic drag: the nonlinear sibling of the paper's robot."""

from math import inf

import casadi as ca

from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe.system import System


def drag_point(*, sigma: float = 0.5, drag: float = 0.5, gamma_1: float = 0.0) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ − c‖x₂‖x₂ + u, y = x₂, all in the plane.

    The fail-safe is u = −K x₂ with K = max(γ₁ − σ, 0). Drag acts along the velocity, so the path is a straight
    segment no longer than without drag, and the damped point's argument holds unchanged.

    Args:
        sigma: Linear damping σ, 1/s, positive.
        drag: Quadratic drag c, 1/m, not negative.
        gamma_1: Largest gain of the first class-K function among the barriers, 1/s.
    """
    if not sigma > 0:
        raise DesignError("drag point sigma", sigma, "a positive number, 1/s")
    if not drag >= 0:
        raise DesignError("drag point drag", drag, "zero or a positive number, 1/m")
    if not 0 <= gamma_1 < inf:
        raise DesignError("drag point gamma_1", gamma_1, "zero or a positive finite number, 1/s")
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    position, velocity = x[:2], x[2:]
    # The norm's slope is undefined at rest; this one differs from it by less than 1e-9 m/s and is smooth.
    speed = ca.sqrt(ca.sumsqr(velocity) + 1e-18)
    gain = max(gamma_1 - sigma, 0.0)
    return Robot(
        system=System(x=x, u=u, f=ca.vertcat(velocity, -(sigma + drag * speed) * velocity + u), y=velocity),
        position=position,
        velocity=velocity,
        fail_safe=-gain * velocity,
        fail_safe_gain=gain,
        fail_safe_condition=f"ψ₁ ≥ 0 with linear γ₁ ≤ {sigma + gain:g}/s, no bound on u in the way",
    )
