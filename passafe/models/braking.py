"""The fail-safe u = −K·velocity of robots whose input is a force: what it keeps, and why.

With v̇ = −σv + u/m and κ = σ + K/m in every axis, the velocity keeps its direction and decays with κ, so that the
position moves on the straight segment from p to p + v/κ. Drag along the velocity, and inputs held between samples, only
make it stop earlier, as long as the velocity does not turn round within a period (``passafe.models.held_braking``); so
K is never larger than that allows. From a state with h ≥ 0 that segment is kept in h ≥ 0

* if h is convex in p, ψ₁ = ḣ + γ₁h ≥ 0 and γ₁ ≤ κ is linear: a convex function lies above its tangents, so
  h(p + s v) ≥ h + s ∇h·v ≥ (1 − sγ₁) h ≥ 0 for 0 ≤ s ≤ 1/κ. Disks and ellipses kept out of, half-planes, boxes and
  the separation of two robots are convex. Held inputs stop within v/κ₁ with a κ₁ ≥ κ, which then stands for κ;
* if {p : h ≥ 0} is convex, as a disk or an ellipse to stay in is, exactly if p + v/κ is in it. ψ₁ ≥ 0 does not ensure
  that: where it holds with equality, a disk to stay in is left by up to ‖v‖²/κ² in h;
* if h is a function of the velocity whose set is star-shaped about rest, always: the velocity only gets shorter.

Nothing stops an obstacle that moves by itself: no law that brings the robot to rest keeps h(x, t) of such a one.
"""

from collections.abc import Callable

import casadi as ca

from passafe.arguments.ranges import require_not_negative, require_positive
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.held_braking import HeldBraking, longest_hold_s
from passafe.models.robot import Robot
from passafe.parameter import Parameter
from passafe.system import System


def braking_robot(
    name: str,
    *,
    axes: int,
    points: int,
    sigma: float,
    gamma_1: float,
    dt_s: float,
    mass: float = 1.0,
    damping: Callable[[ca.SX, ca.SX], ca.SX] | None = None,
    drive: Callable[[ca.SX], ca.SX] | None = None,
    others: tuple[Parameter, ...] = (),
) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + u/m or with another damping and drive, y = x₂, with u = −K x₂ as fail-safe.

    K/m = max(γ₁ − σ, 0), but never more than stops the robot within one period, σ/(e^{σdt} − 1). Its parameters are
    ``mass``, ``sigma`` and those of damping and drive.

    Args:
        name: The robot's, for messages.
        axes: Number of coordinates and of inputs.
        points: See ``Robot``.
        sigma: Linear damping σ, 1/s, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.
        mass: m, by which the drive's force is divided, positive.
        damping: Returns what acts in the place of −σx₂ for x₂, shape (axes, 1), and σ; it may only act along x₂.
        drive: Returns what acts in the place of u, which has shape (axes, 1).
        others: Parameters of damping and drive.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive(f"{name} sigma", sigma, "1/s")
    require_not_negative(f"{name} gamma_1", gamma_1, "1/s")
    require_not_negative(f"{name} dt_s", dt_s, "s")
    require_positive(f"{name} mass", mass)
    x, u = ca.SX.sym("x", 2 * axes), ca.SX.sym("u", axes)
    position, velocity = x[:axes], x[axes:]
    slowing, inertia = Parameter.of("sigma", sigma), Parameter.of("mass", mass)
    resisted = -slowing.symbol * velocity if damping is None else damping(velocity, slowing.symbol)
    pushed = resisted + (u if drive is None else drive(u)) / inertia.symbol
    system = System(x=x, u=u, f=ca.vertcat(velocity, pushed), y=velocity, parameters=(inertia, slowing, *others))
    held = HeldBraking(sigma=sigma, dt_s=dt_s)
    wanted = max(gamma_1, sigma) - sigma
    gain = min(wanted, held.largest_gain)
    kept = sigma + gain if gain == wanted else held.kept_gain(gain)
    return Robot(
        system=system,
        position=position,
        velocity=velocity,
        points=points,
        fail_safe=-mass * gain * velocity,
        fail_safe_gain=mass * gain,
        fail_safe_scope=FailSafeScope(dt_s=dt_s, kept_gains=(kept,)),
        stopping_hull=stopping_segment(position, velocity, sigma + gain),
        fail_safe_condition=f"{braking_condition(kept)}; {held_condition(sigma, gain)}",
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


def held_condition(sigma: float, gain: float) -> str:
    """Return the condition under which u = −K v does not overshoot while it is held, in words."""
    longest = longest_hold_s(sigma, gain)
    return f"each of its inputs held for at most {longest:.4g} s, (1 − e^(−σdt))(1 + K/σ) ≤ 1"
