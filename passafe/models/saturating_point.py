"""A damped point whose drive saturates smoothly: its dynamics are not affine in the input."""

from dataclasses import replace
from math import inf, sqrt
from typing import Final

import casadi as ca

from passafe.arguments.ranges import require_positive
from passafe.models.braking import braking_condition, braking_robot, held_condition, stopping_segment
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.held_braking import HeldBraking
from passafe.models.robot import Robot
from passafe.parameter import Parameter

RESERVE: Final = 2.0
"""Factor by which the fail-safe brakes harder than an unsaturated drive would have to."""


def saturating_point(
    *, sigma: float = 1.0, force: float = 20.0, mass: float = 1.0, gamma_1: float = 0.0, dt_s: float = 0.0
) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u/(m√(1 + ‖u‖²/F²)), y = x₂, all in the plane.

    The force has the direction of u and stays shorter than F. Positions have relative degree 2, velocities 1.

    The fail-safe is u = −mK x₂ with K = 2(γ₁ − σ), or 0 if γ₁ ≤ σ, but never more than stops an unsaturated drive in
    one period (``passafe.models.held_braking``). A drive that gives a share φ/K of what is asked for brakes as K = φ
    would, and stops soon enough for φ ≥ N, N the least gain for γ₁: as long as ‖x₂‖ ≤ (F/m)√(1/N² − 1/K²), and φ grows
    as the speed falls. So from such a speed the path is a straight segment no longer than ‖x₂‖/κ, κ = max(γ₁, σ), and
    keeps what ``passafe.models.braking`` states. Where K is limited to less than 2N, N is K/2 and κ what that keeps.

    Args:
        sigma: Damping σ, 1/s, positive.
        force: F, largest force, N (N/kg where the mass is left at 1), positive.
        mass: m, by which the force is divided, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive("saturating point force", force, "N/kg")
    largest = Parameter.of("force", force)

    def drive(u: ca.SX) -> ca.SX:
        return u / ca.sqrt(1 + ca.sumsqr(u) / largest.symbol**2)

    robot = braking_robot(
        "saturating point",
        axes=2,
        points=1,
        sigma=sigma,
        gamma_1=gamma_1,
        dt_s=dt_s,
        mass=mass,
        drive=drive,
        others=(largest,),
    )
    held = HeldBraking(sigma=sigma, dt_s=dt_s)
    gain = min(RESERVE * max(gamma_1 - sigma, 0.0), held.largest_gain)
    least = min(held.least_gain(gamma_1), gain / RESERVE)
    kept = held.kept_gain(least)
    top_speed = force / mass * sqrt(1 / least**2 - 1 / gain**2) if gain else inf
    return replace(
        robot,
        fail_safe=-mass * gain * robot.velocity,
        fail_safe_gain=mass * gain,
        fail_safe_scope=FailSafeScope(dt_s=dt_s, kept_gains=(kept,), top_speed=top_speed),
        stopping_hull=stopping_segment(robot.position, robot.velocity, kept),
        fail_safe_condition=(
            f"speed at most {top_speed:g} m/s; {braking_condition(kept)}; {held_condition(sigma, gain)}"
        ),
    )
