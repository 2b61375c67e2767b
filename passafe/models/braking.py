"""The fail-safe u = −K·velocity of robots whose input is a force: what it keeps, and why.

With v̇ = −σv + u and κ = σ + K in every axis, the velocity keeps its direction and decays with κ, so that the position
moves on the straight segment from p to p + v/κ. Drag along the velocity, and an input held between samples, only make
it stop earlier. From a state with h ≥ 0 that segment is kept in h ≥ 0

* if h is convex in p, ψ₁ = ḣ + γ₁h ≥ 0 and γ₁ ≤ κ is linear: a convex function lies above its tangents, so
  h(p + s v) ≥ h + s ∇h·v ≥ (1 − sγ₁) h ≥ 0 for 0 ≤ s ≤ 1/κ. Disks and ellipses kept out of, half-planes, boxes and
  the separation of two robots are convex;
* if {p : h ≥ 0} is convex, as a disk or an ellipse to stay in is, exactly if p + v/κ is in it. ψ₁ ≥ 0 does not ensure
  that: where it holds with equality, a disk to stay in is left by up to ‖v‖²/κ² in h;
* if h is a function of the velocity whose set is star-shaped about rest, always: the velocity only gets shorter.

Nothing stops an obstacle that moves by itself: no law that brings the robot to rest keeps h(x, t) of such a one.
"""

from collections.abc import Callable

import casadi as ca

from passafe.models.robot import Robot
from passafe.ranges import require_not_negative, require_positive
from passafe.system import System


def braking_robot(
    name: str,
    *,
    axes: int,
    points: int,
    sigma: float,
    gamma_1: float,
    acceleration: Callable[[ca.SX, ca.SX], ca.SX] | None = None,
) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u or another acceleration, y = x₂, with u = −K x₂ as fail-safe, K = max(γ₁ − σ, 0).

    Args:
        name: The robot's, for messages.
        axes: Number of coordinates and of inputs.
        points: See ``Robot``.
        sigma: Linear damping σ, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        acceleration: Returns ẋ₂ for x₂ and u, each of shape (axes, 1); with it, drag may only act along x₂.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive(f"{name} sigma", sigma, "1/s")
    require_not_negative(f"{name} gamma_1", gamma_1, "1/s")
    x, u = ca.SX.sym("x", 2 * axes), ca.SX.sym("u", axes)
    position, velocity = x[:axes], x[axes:]
    pushed = -sigma * velocity + u if acceleration is None else acceleration(velocity, u)
    rate = max(gamma_1, sigma)
    return Robot(
        system=System(x=x, u=u, f=ca.vertcat(velocity, pushed), y=velocity),
        position=position,
        velocity=velocity,
        points=points,
        fail_safe=-(rate - sigma) * velocity,
        fail_safe_gain=rate - sigma,
        stopping_hull=stopping_segment(position, velocity, rate),
        fail_safe_condition=braking_condition(rate),
    )


def stopping_segment(position: ca.SX, velocity: ca.SX, rate_per_s: float) -> tuple[ca.SX, ca.SX]:
    """Return both ends of the segment on which the position moves while v̇ = −κv.

    Args:
        position: p, shape (k, 1).
        velocity: v, shape (k, 1).
        rate_per_s: κ, positive, 1/s.
    """
    return position, position + velocity / rate_per_s


def braking_condition(rate_per_s: float) -> str:
    """Return the condition under which braking with κ keeps a barrier of the position, in words."""
    return (
        f"ψ₁ ≥ 0 with linear γ₁ ≤ {rate_per_s:g}/s and h convex in the position; for a convex set to stay in, "
        f"position + velocity/({rate_per_s:g}/s) in it; no bound on u in the way, no obstacle that moves by itself"
    )
