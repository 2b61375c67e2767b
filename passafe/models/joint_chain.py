"""Damped joints side by side: for limits of joints and their speeds, with as many inputs as an arm has."""

from passafe.errors import DesignError
from passafe.models.braking import braking_robot
from passafe.models.robot import Robot

MOST_JOINTS = 7


def joint_chain(*, joints: int = MOST_JOINTS, sigma: float = 1.0, gamma_1: float = 0.0, dt_s: float = 0.0) -> Robot:
    """Return q̈ᵢ = −σq̇ᵢ + uᵢ for every joint, x = (q, q̇), y = q̇: an arm whose dynamics have been compensated.

    Angles have relative degree 2, speeds 1. The fail-safe is u = −K q̇ with K = max(γ₁ − σ, 0); what it keeps, and
    why, is in ``passafe.models.braking``, with κ = σ + K.

    Args:
        joints: Number of joints, 1 to 7.
        sigma: Damping σ of each, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the angles, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    if joints not in range(1, MOST_JOINTS + 1):
        raise DesignError("joint chain joints", joints, f"1 to {MOST_JOINTS}")
    return braking_robot("joint chain", axes=joints, points=0, sigma=sigma, gamma_1=gamma_1, dt_s=dt_s)
