"""The paper's robot: a point mass in the plane with linear damping (paper, equation 25)."""

from passafe.models.braking import braking_robot
from passafe.models.robot import Robot


def damped_point(*, sigma: float = 1.0, mass: float = 1.0, gamma_1: float = 0.0, dt_s: float = 0.0) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u/m, y = x₂, all in the plane.

    Positions have relative degree 2, velocities 1. The fail-safe is u = −K x₂ with K/m = max(γ₁ − σ, 0); what it keeps,
    and why, is in ``passafe.models.braking``, with κ = σ + K/m.

    Args:
        sigma: Damping σ, 1/s, positive.
        mass: m, by which the force is divided, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    return braking_robot("damped point", axes=2, points=1, sigma=sigma, gamma_1=gamma_1, dt_s=dt_s, mass=mass)
