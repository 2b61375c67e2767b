"""The paper's robot: a point mass in the plane with linear damping (paper, equation 25)."""

from math import inf

import casadi as ca

from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe.system import System


def damped_point(*, sigma: float = 1.0, gamma_1: float = 0.0) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u, y = x₂, all in the plane.

    The fail-safe is u = −K x₂ with K = max(γ₁ − σ, 0). Its path is the straight segment from x₁ to
    x₁ + x₂/(σ + K), and ‖x₁ + s x₂‖² − d² ≥ (1 − sγ₁)(‖x₁‖² − d²) + s²‖x₂‖² ≥ 0 for 0 ≤ s ≤ 1/γ₁ wherever
    ψ₁ ≥ 0 and γ₁ is linear: so it keeps every disk whose first class-K gain is at most γ₁, from any state that
    the filter can hand over. The same holds for half-planes.

    Args:
        sigma: Damping σ, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers, 1/s.
    """
    if not sigma > 0:
        raise DesignError("damped point sigma", sigma, "a positive number, 1/s")
    if not 0 <= gamma_1 < inf:
        raise DesignError("damped point gamma_1", gamma_1, "zero or a positive finite number, 1/s")
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    position, velocity = x[:2], x[2:]
    gain = max(gamma_1 - sigma, 0.0)
    return Robot(
        system=System(x=x, u=u, f=ca.vertcat(velocity, -sigma * velocity + u), y=velocity),
        position=position,
        velocity=velocity,
        fail_safe=-gain * velocity,
        fail_safe_gain=gain,
        fail_safe_condition=f"ψ₁ ≥ 0 with linear γ₁ ≤ {sigma + gain:g}/s, no bound on u in the way",
    )
