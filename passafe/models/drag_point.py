"""A point mass in the plane with quadratic drag: the nonlinear sibling of the paper's robot."""

from dataclasses import replace

import casadi as ca

from passafe.arguments.ranges import require_not_negative
from passafe.models.braking import braking_condition, braking_robot
from passafe.models.held_braking import HeldBraking
from passafe.models.robot import Robot
from passafe.parameter import Parameter


def drag_point(
    *, sigma: float = 0.5, drag: float = 0.5, mass: float = 1.0, gamma_1: float = 0.0, dt_s: float = 0.0
) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ − c‖x₂‖x₂ + u/m, y = x₂, all in the plane.

    Positions have relative degree 2, velocities 1. The fail-safe is u = −mK x₂ with K = max(γ₁ − σ, 0); what it keeps,
    and why, is in ``passafe.models.braking``, with κ = σ + K: drag acts along the velocity, so the path is a straight
    segment no longer than without it.

    An input that is held for dt must not turn the velocity round. With a = e^{−σdt}, q = (1 − a)/σ, the point alone
    would coast to a‖x₂‖/(1 + cq‖x₂‖), and K takes no more than Kq‖x₂‖ of that: so K is at most a/(q(1 + cq‖x₂‖)).
    Where that is less than γ₁ − σ, drag does the rest. For a way d q‖x₂‖ in the period, C = cq‖x₂‖ and e^{−σt} taken
    out of the speed, Cauchy and Schwarz leave d ≤ Cd² + 1/(1 + C) to be shown for a way within q times the speed that
    is lost: true for C ≥ 1/3, where the discriminant is not positive. For C ≤ 1/2 the way without drag is short enough.
    So γ₁ ≤ 1/q is kept at any speed.

    Args:
        sigma: Linear damping σ, 1/s, positive.
        drag: Quadratic drag c, 1/m, not negative.
        mass: m, by which the force is divided, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_not_negative("drag point drag", drag, "1/m")

    quadratic = Parameter.of("drag", drag)

    def damping(velocity: ca.SX, linear: ca.SX) -> ca.SX:
        return -(linear + quadratic.symbol * _speed(velocity)) * velocity

    robot = braking_robot(
        "drag point",
        axes=2,
        points=1,
        sigma=sigma,
        gamma_1=gamma_1,
        dt_s=dt_s,
        mass=mass,
        damping=damping,
        others=(quadratic,),
    )
    if not (dt_s and robot.fail_safe_gain):
        return robot
    gain = robot.fail_safe_gain / mass
    held, rate = HeldBraking(sigma=sigma, dt_s=dt_s), sigma + gain
    most = held.largest_gain / (1 + drag * held.reach_s * _speed(robot.velocity))
    return replace(
        robot,
        fail_safe=-mass * ca.fmin(gain, most) * robot.velocity,
        fail_safe_scope=replace(robot.fail_safe_scope, kept_gains=(rate,)),
        fail_safe_condition=f"{braking_condition(rate)}; each of its inputs held for at most {dt_s:.4g} s",
    )


def _speed(velocity: ca.SX) -> ca.SX:
    """Return ‖v‖, but smooth at rest: the norm's slope is undefined there, and this differs by less than 1e-9 m/s."""
    return ca.sqrt(ca.sumsqr(velocity) + 1e-18)
