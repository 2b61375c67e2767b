"""The margin ε(T) that keeps a barrier while an input is held, not only at samples (``docs/theory.md``, section 6).

Let p = ψ_{r−1} be the last function of a chain before u appears, and u⁺ be held over [0, T]: a period, or longer where
the plant holds an input because no other follows. If −p̈ ≤ M meanwhile,

    p(τ) ≥ p(0) + τ ṗ(0) − ½ τ² M   for 0 ≤ τ ≤ T,

so with γ(s) ≤ s/T for s ≥ 0 the row ṗ(0) + γ(p(0)) ≥ ε = ½ T max(M, 0) gives p(τ) ≥ (1 − τ/T) p(0) ≥ 0. Then
ψ_{r−2} … ψ₀ = h stay at or above zero by the comparison lemma (Khalil 2002, lemma 3.4), sampled or not.
"""

from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.class_k import Linear
from passafe.enclosure import enclose
from passafe.system import System

UNKNOWN: Final = 1e30
"""Bound where nothing is known: large but finite, because infinity times zero is NaN."""

GROWTH: Final = 2.0
"""Factor by which the guessed tube around a period is wider than what was last found to be reached."""


def curvature_bound(system: System, p: ca.SX, held_s: float, input_radius: ca.SX, steps: int) -> ca.SX:
    """Return M(x, u, t) with −p̈ ≤ M over the next ``held_s`` seconds under any held input near u, scalar expression.

    p̈ is enclosed over a tube around x that no trajectory leaves before T is over: a tube with radius R such that
    T·|f| ≤ R all over it (Picard–Lindelöf). Where the guessed R is too small, M is ``UNKNOWN``, practically infinite.

    Args:
        system: The plant.
        p: Expression of x and t whose second derivative is bounded.
        held_s: T, how long the input is held at most, s.
        input_radius: By how much each axis of the held input may differ from u, expression, shape (m, 1).
        steps: How often the tube's guess is refined; as often as there are integrations between u and p.

    Raises:
        DesignError: p or the dynamics have an operation without an enclosure.
    """

    def speed(reach: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return a bound of |f| while x moves by no more than ``reach``, shape (n, 1), and whether it is known."""
        ball = enclose(system.f, ca.vertcat(system.x, system.u), ca.vertcat(reach, input_radius))
        return ca.fabs(ball.centre) + ball.radius, ball.known

    radius = ca.SX.zeros(system.n)
    for _ in range(steps):
        radius = held_s * GROWTH * speed(radius)[0]
    fastest, known = speed(radius)
    inside = ca.logic_and(known, ca.mmax(held_s * fastest - radius) <= 0)
    bend = system.rate(system.rate(p))
    ball = enclose(-bend, ca.vertcat(system.x, system.u, system.t), ca.vertcat(radius, input_radius, held_s))
    return ca.if_else(ca.logic_and(inside, ball.known), ball.centre + ball.radius, UNKNOWN)


def held_function(system: System, chain: BarrierChain, held_s: float) -> ca.SX:
    """Return ṗ + γ̃(p) as an expression of x, u and t, where γ̃ is γ_r, but no more than p/T for p > 0.

    A sampled input cannot use more: γ with a larger value lets p jump over zero before it ends. It differs from
    ψ_r only where γ_r(p) > p/T.
    """
    r = chain.relative_degree
    p, gamma = chain.psi[r - 1], chain.barrier.class_k[r - 1]
    if isinstance(gamma, Linear) and gamma.gain * held_s <= 1:
        return chain.psi[r]
    value = gamma(p)
    return system.rate(p) + ca.if_else(p > 0, ca.fmin(value, p / held_s), value)
