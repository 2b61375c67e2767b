"""A damped point whose drive saturates smoothly: its dynamics are not affine in the input."""

from dataclasses import replace
from math import inf, sqrt
from typing import Final

import casadi as ca

from passafe.models.braking import braking_robot
from passafe.models.robot import Robot
from passafe.ranges import require_positive

RESERVE: Final = 2.0
"""Factor by which the fail-safe brakes harder than an unsaturated drive would have to."""


def saturating_point(*, sigma: float = 1.0, force: float = 20.0, gamma_1: float = 0.0) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u/√(1 + ‖u‖²/F²), y = x₂, all in the plane.

    The force has the direction of u and stays shorter than F. Positions have relative degree 2, velocities 1.

    The fail-safe is u = −K x₂ with K = 2(γ₁ − σ), or 0 if γ₁ ≤ σ. It brakes along the velocity with the rate
    σ + K/√(1 + K²‖x₂‖²/F²), which is at least γ₁ as long as ‖x₂‖ ≤ √¾·F/(γ₁ − σ), and grows as the speed falls. So
    from such a speed the path is a straight segment no longer than ‖x₂‖/κ with κ = max(γ₁, σ), and keeps what
    ``passafe.models.braking`` states.

    Args:
        sigma: Damping σ, 1/s, positive.
        force: F, largest force for each unit of mass, N/kg, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive("saturating point force", force, "N/kg")

    def acceleration(velocity: ca.SX, u: ca.SX) -> ca.SX:
        return -sigma * velocity + u / ca.sqrt(1 + ca.sumsqr(u) / force**2)

    robot = braking_robot("saturating point", axes=2, points=1, sigma=sigma, gamma_1=gamma_1, acceleration=acceleration)
    excess = max(gamma_1 - sigma, 0.0)
    top_speed = sqrt(1 - 1 / RESERVE**2) * force / excess if excess else inf
    return replace(
        robot,
        fail_safe=-RESERVE * excess * robot.velocity,
        fail_safe_gain=RESERVE * excess,
        fail_safe_condition=f"speed at most {top_speed:g} m/s; {robot.fail_safe_condition}",
    )
