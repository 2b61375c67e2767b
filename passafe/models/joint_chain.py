"""Damped joints side by side: for limits of joints and their speeds, with as many inputs as an arm has."""

import casadi as ca

from passafe.errors import DesignError
from passafe.models.braking import braking_condition, stopping_segment
from passafe.models.robot import Robot
from passafe.ranges import require_not_negative, require_positive
from passafe.system import System

MOST_JOINTS = 7


def joint_chain(*, joints: int = MOST_JOINTS, sigma: float = 1.0, gamma_1: float = 0.0) -> Robot:
    """Return q̈ᵢ = −σq̇ᵢ + uᵢ for every joint, x = (q, q̇), y = q̇: an arm whose dynamics have been compensated.

    Angles have relative degree 2, speeds 1. The fail-safe is u = −K q̇ with K = max(γ₁ − σ, 0); what it keeps, and
    why, is in ``passafe.models.braking``, with κ = σ + K.

    Args:
        joints: Number of joints, 1 to 7.
        sigma: Damping σ of each, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the angles, 1/s.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    if joints not in range(1, MOST_JOINTS + 1):
        raise DesignError("joint chain joints", joints, f"1 to {MOST_JOINTS}")
    require_positive("joint chain sigma", sigma, "1/s")
    require_not_negative("joint chain gamma_1", gamma_1, "1/s")
    x, u = ca.SX.sym("x", 2 * joints), ca.SX.sym("u", joints)
    position, velocity = x[:joints], x[joints:]
    rate = max(gamma_1, sigma)
    return Robot(
        system=System(x=x, u=u, f=ca.vertcat(velocity, -sigma * velocity + u), y=velocity),
        position=position,
        velocity=velocity,
        points=0,
        fail_safe=-(rate - sigma) * velocity,
        fail_safe_gain=rate - sigma,
        stopping_hull=stopping_segment(position, velocity, rate),
        fail_safe_condition=braking_condition(rate),
    )
