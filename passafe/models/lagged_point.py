"""A damped point whose force follows its command with a lag: positions have relative degree 3."""

import casadi as ca

from passafe.arguments.ranges import require_not_negative, require_positive
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.held_lagged_braking import HeldLaggedBraking, LaggedGains, held_gains
from passafe.models.robot import Robot
from passafe.parameter import Parameter
from passafe.system import System


def lagged_point(
    *,
    sigma: float = 1.0,
    lag_s: float = 0.05,
    mass: float = 1.0,
    gamma_1: float = 0.0,
    gamma_2: float = 0.0,
    dt_s: float = 0.0,
) -> Robot:
    """Return ẋ₁ = x₂, ẋ₂ = −σx₂ + x₃/m, ẋ₃ = (u − x₃)/T, y = x₂, all in the plane.

    Positions have relative degree 3, velocities 2. yᵀu is the power of the commanded force, not of the one that acts:
    between them lie two poles, so no storage makes this robot passive by itself, and the filter has to.

    The fail-safe is linear in velocity and force and gives the velocity the poles −κ₁, −κ₂, κ₁ = max(γ₁, slow),
    κ₂ = max(γ₁, γ₂, fast), where slow and fast are the robot's own, σ and 1/T in their order; if it needs no faster
    ones, u = 0. With a = ẋ₂, q = x₁ + x₂/κ₁ moves straight, as q̇ = x₂ + a/κ₁ decays with κ₂, and ẋ₁ = κ₁(q − x₁): so
    x₁ never leaves the triangle of

        x₁,   q = x₁ + x₂/κ₁,   p∞ = x₁ + ((κ₁ + κ₂)x₂ + a)/(κ₁κ₂), where it comes to rest.

    From a state with h, ψ₁, ψ₂ ≥ 0, γ₁ and γ₂ linear, that triangle is kept in h ≥ 0

    * if h is affine in x₁ (half-planes, boxes): h(q) = (ψ₁ + (κ₁ − γ₁)h)/κ₁ and
      h(p∞) = (ψ₂ + (κ₁ + κ₂ − γ₁ − γ₂)ψ₁ + (κ₁ − γ₁)(κ₂ − γ₁)h)/(κ₁κ₂) are not negative, since κ₁, κ₂ ≥ γ₁, κ₂ ≥ γ₂;
    * if h is convex in x₁ and ψ₂ ≥ x₂ᵀ∇²h x₂, by the same for h's tangent at x₁. With ψ₂ ≥ 0 alone the force that is
      still acting may carry the robot across a curved boundary, by no more than h ≥ −x₂ᵀ∇²h x₂/(κ₁κ₂);
    * if {x₁ : h ≥ 0} is convex, as a disk to stay in is, where the three points are in it.

    All this is for the law in continuous time. With inputs that are each held for dt the gains are chosen so that the
    first two points still hold, though not the triangle: ``passafe.models.held_lagged_braking``.

    Args:
        sigma: Damping σ, 1/s, positive.
        lag_s: T, s, positive.
        mass: m, by which the force is divided, positive.
        gamma_1: Largest gain of the first class-K function among the barriers of the position, 1/s.
        gamma_2: Largest gain of the second one, 1/s.
        dt_s: How long each input of the fail-safe is held, s; 0 for a law that is followed at every instant.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive("lagged point sigma", sigma, "1/s")
    require_positive("lagged point lag_s", lag_s, "s")
    require_positive("lagged point mass", mass)
    require_not_negative("lagged point gamma_1", gamma_1, "1/s")
    require_not_negative("lagged point gamma_2", gamma_2, "1/s")
    require_not_negative("lagged point dt_s", dt_s, "s")
    x, u = ca.SX.sym("x", 6), ca.SX.sym("u", 2)
    position, velocity, force = x[:2], x[2:4], x[4:]
    acceleration = force / mass - sigma * velocity
    slow, fast = sorted((sigma, 1 / lag_s))
    k_1, k_2 = max(gamma_1, slow), max(gamma_1, gamma_2, fast)
    # ȧ = (u − x₃)/T − σa is to be −(κ₁ + κ₂)a − κ₁κ₂x₂; written so that nothing is left where κ₁, κ₂ are its own.
    gains = LaggedGains(on_velocity=lag_s * (k_1 - sigma) * (k_2 - sigma), on_force=1 + lag_s * (sigma - k_1 - k_2))
    is_kept = True
    if dt_s:
        held = HeldLaggedBraking(sigma=sigma, lag_s=lag_s, gamma_1=k_1, gamma_2=k_2, dt_s=dt_s)
        gains, is_kept = held_gains(held, k_1, k_2, gains)
    at_rest = position + ((k_1 + k_2) * velocity + acceleration) / (k_1 * k_2)
    return Robot(
        system=_system(x, u, mass=mass, sigma=sigma, lag_s=lag_s),
        position=position,
        velocity=velocity,
        points=1,
        fail_safe=-mass * gains.on_velocity * velocity + gains.on_force * force,
        fail_safe_gain=mass * gains.on_velocity,
        fail_safe_scope=FailSafeScope(dt_s=dt_s, kept_gains=(k_1, k_2) if is_kept else (0.0, 0.0)),
        stopping_hull=(position, position + velocity / k_1, at_rest),
        fail_safe_condition=_condition(k_1, k_2, dt_s) if is_kept else "none: held so long it keeps no barrier",
    )


def _system(x: ca.SX, u: ca.SX, *, mass: float, sigma: float, lag_s: float) -> System:
    """Return the dynamics, with their parameters."""
    inertia, slowing, lag = (Parameter.of(*each) for each in (("mass", mass), ("sigma", sigma), ("lag_s", lag_s)))
    velocity, force = x[2:4], x[4:]
    acceleration = force / inertia.symbol - slowing.symbol * velocity
    f = ca.vertcat(velocity, acceleration, (u - force) / lag.symbol)
    return System(x=x, u=u, f=f, y=velocity, parameters=(inertia, slowing, lag))


def _condition(k_1: float, k_2: float, dt_s: float) -> str:
    """Return the condition under which the fail-safe keeps a barrier of the position, in words."""
    return (
        f"h, ψ₁, ψ₂ ≥ 0 with linear γ₁ ≤ {k_1:g}/s and γ₁, γ₂ ≤ {k_2:g}/s, and h affine in the position, or convex "
        "with ψ₂ ≥ x₂ᵀ∇²h x₂; for a convex set to stay in, position, position + velocity/κ₁ and the place of rest "
        "in it; no bound on u in the way, no obstacle that moves by itself; "
        + (f"each of its inputs held for {dt_s:.4g} s" if dt_s else "followed at every instant")
    )
