"""Two of the paper's robots in one plane, driven at once: for the distance between robots."""

from passafe.models.braking import braking_robot
from passafe.models.robot import Robot


def two_points(*, sigma: float = 1.0, mass: float = 1.0, gamma_1: float = 0.0, dt_s: float = 0.0) -> Robot:
    """Return two points with ṗ = v, v̇ = −σv + u/m each; x = (p₁, p₂, v₁, v₂), u = (u₁, u₂), y = (v₁, v₂).

    Positions have relative degree 2, velocities 1. The fail-safe is u = −K(v₁, v₂) with K/m = max(γ₁ − σ, 0); what it
    keeps, and why, is in ``passafe.models.braking``, with κ = σ + K/m: both points brake alike, so all four coordinates
    together move on a straight segment, and the separation is convex in them.

    Args:
        sigma: Damping σ of both, 1/s, positive.
        mass: m of both, by which the force is divided, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    return braking_robot("two points", axes=4, points=2, sigma=sigma, gamma_1=gamma_1, dt_s=dt_s, mass=mass)
