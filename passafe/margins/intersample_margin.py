"""The margin that keeps a barrier while an input is held, not only at samples (``docs/theory.md``, section 6).

Let p(x, t) be the last function of a chain before u appears, and u⁺ be held over [0, T]: a period, or longer where the
plant holds an input because no other follows. With q = ṗ, a rate λ ≥ 0 and b = q̇ + λq let |b(τ) − b(0)| ≤ V meanwhile.
Then q̇ ≥ −λq + b − V, and with φ₁(τ) = (1 − e^{−λτ})/λ and φ₂(τ) = (τ − φ₁(τ))/λ (τ and τ²/2 for λ = 0)

    p(τ) ≥ p(0) + φ₁(τ)q(0) + φ₂(τ)(b(0) − V)   for 0 ≤ τ ≤ T.

φ₂/φ₁ grows with τ, so with ratio = φ₂(T)/φ₁(T) and γ̃(s) ≤ s/φ₁(T) for s ≥ 0 the two conditions

    q + γ̃(p) ≥ 0   and   q + γ̃(p) + ratio·(b − V) ≥ 0

give p(τ) ≥ (1 − φ₁(τ)/φ₁(T)) p(0) ≥ 0. Then ψ_{r−2} … ψ₀ = h stay at or above zero by the comparison lemma (Khalil
2002, lemma 3.4), sampled or not. b is known exactly; only V is a bound, and ratio·V is of the order of T².
"""

from dataclasses import dataclass, replace
from math import expm1
from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.class_k import ClassK, Linear
from passafe.enclosures.angle_cuts import apart_from_cuts
from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.enclosures.enclosure import enclose
from passafe.enclosures.jump_bound import jump_bound
from passafe.enclosures.reachable_tube import Tube
from passafe.errors import DesignError
from passafe.passivity import Passivity, power_margin
from passafe.system import System

SLOW: Final = 0.05
"""λT below which λ = 0 is taken: there it gains nothing."""

PROBES: Final = 5
"""States at which λ is sought; the median is taken."""


class DeviationBound(NamedTuple):
    """Bound of what an unknown change of b can take, in the units of q.

    Attributes:
        size: ratio·V, expression of x, u and t.
        known: 1 where it is proven, else 0, expression.
    """

    size: ca.SX
    known: ca.SX


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BoundSum:
    """Weighted sum of bounds of a function's time derivatives.

    Attributes:
        bounds: Of the derivatives 1, 2, ….
        weights: Of each.
    """

    bounds: DerivativeBounds
    weights: tuple[float, ...]

    @classmethod
    def of_chain(cls, chain: BarrierChain, decay_per_s: float, scale: float) -> "BoundSum | None":
        """Return the bound of scale·|ḃ| of a chain, ḃ = (d/dt + λ)(d/dt)²p; ``None`` if none is given.

        Raises:
            DesignError: A class-K function below the last that is not linear, or too few derivatives.
        """
        bounds, r = chain.barrier.derivative_bounds, chain.relative_degree
        if bounds is None:
            return None
        part, shaping = f"barrier {chain.barrier.name!r}", chain.barrier.class_k[: r - 1]
        if int(bounds.orders.numel()) < r + 2:
            got, allowed = f"{bounds.orders.numel()} derivatives", f"{r + 2}, two more than its relative degree"
            raise DesignError(f"{part} derivative_bounds", got, allowed)
        if not all(isinstance(gamma, Linear) for gamma in shaping):
            raise DesignError(f"{part} class_k", str(shaping), "linear ones, where derivative bounds are given")
        factors = (decay_per_s, *(gamma.gain for gamma in shaping))
        roots = np.poly([-factor for factor in factors])[::-1]  # coefficients of d/dt, the lowest power first
        return cls(bounds=bounds, weights=(0.0, *(scale * roots).tolist()))

    def within(self, system: System, tube: Tube, held_s: float, input_radius: ca.SX) -> ca.SX:
        """Return the sum for all motions in a tube; see ``DerivativeBounds.within``."""
        orders = self.bounds.within(system, tube, held_s, input_radius)
        return ca.dot(ca.DM(self.weights), orders[: len(self.weights)])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class HeldRow:
    """The two conditions on a held input, as expressions of x, u and t.

    Attributes:
        value: q + γ̃(p).
        bend: ratio·b, the part of the second condition that is known.
        p: p.
        usable_s: φ₁(T), s: γ̃(p) is no more than p/φ₁(T) for p > 0.
        ratio_s: ratio, s.
        decay_per_s: λ, 1/s.
        q: q.
        gain: Slope of γ̃ in p where it is the same everywhere, 1/s.
        continuous: What q is the rate of, as far as it depends on x and t: it must not jump.
        change: Bound of ratio·|ḃ| as a sum of given bounds of h's derivatives, if there are any.
    """

    value: ca.SX
    bend: ca.SX
    p: ca.SX
    usable_s: float
    ratio_s: float
    decay_per_s: float
    q: ca.SX
    continuous: ca.SX
    gain: float | None = None
    change: BoundSum | None = None

    def deviation(self, system: System, tube: Tube, held_s: float, input_radius: ca.SX) -> DeviationBound:
        """Return the bound of ratio·|b(τ) − b(0)| over the tube under any held input near u.

        The mean-value form: the gradient of b in x and t, enclosed over the tube, times how far these may move. Where
        the dynamics have kinks b jumps; so what jumps within reach can take comes on top. With bounds that are given,
        V = T·sup|ḃ|.

        Args:
            system: The plant.
            tube: Around x, for the same inputs.
            held_s: T, s.
            input_radius: By how much each axis of the held input may differ from u, expression, shape (m, 1).

        Raises:
            DesignError: p or the dynamics have an operation without an enclosure.
        """
        moving, reach = ca.vertcat(system.x, system.t), ca.vertcat(tube.radius, held_s)
        tube_known = tube.known * apart_from_cuts(self.continuous, moving, reach)
        if self.change is not None:
            return DeviationBound(held_s * self.change.within(system, tube, held_s, input_radius), tube_known)
        slope = ca.gradient(self.bend, moving)
        ball = enclose(slope, ca.vertcat(moving, system.u), ca.vertcat(reach, input_radius))
        jumps, known = jump_bound(self.bend, moving, reach, system.u, input_radius)
        size = ca.dot(ca.fabs(ball.centre) + ball.radius, reach) + jumps
        return DeviationBound(size, tube_known * ball.known * known)


def held_row(system: System, chain: BarrierChain, held_s: float, *, decay_per_s: float | None = None) -> HeldRow:
    """Return the conditions for ψ_{r−1} ≥ 0 of a barrier under a held input.

    Args:
        system: The plant.
        chain: The barrier's.
        held_s: T, how long the input is held at most, s.
        decay_per_s: λ, 1/s, where it is given.
    """
    r = chain.relative_degree
    p = chain.psi[r - 1]
    q = system.rate(p)
    bend = system.rate(q)
    decay = decay_rate(system, q, bend, held_s) if decay_per_s is None else decay_per_s
    row = _held(p, q, bend, chain, held_s, decay)
    return replace(row, value=chain.psi[r]) if _is_usable(chain.barrier.class_k[r - 1], row.usable_s) else row


def general_row(system: System, chain: BarrierChain, held_s: float) -> HeldRow:
    """Return ``held_row`` with the symbols of the system's parameters in it; λ is that of their values."""
    p = chain.psi[chain.relative_degree - 1]
    q = system.general_rate(p)
    bend = system.general_rate(q)
    decay = decay_rate(system, system.at_nominal(q), system.at_nominal(bend), held_s)
    return _held(p, q, bend, chain, held_s, decay)


def _held(p: ca.SX, q: ca.SX, bend: ca.SX, chain: BarrierChain, held_s: float, decay: float) -> HeldRow:
    gamma = chain.barrier.class_k[chain.relative_degree - 1]
    usable_s = held_s if not decay else -expm1(-decay * held_s) / decay
    ratio_s = held_s / 2 if not decay else (held_s - usable_s) / decay / usable_s
    return HeldRow(
        value=q + usable(gamma, p, usable_s),
        bend=ratio_s * (bend + decay * q),
        p=p,
        usable_s=usable_s,
        ratio_s=ratio_s,
        decay_per_s=decay,
        q=q,
        continuous=p,
        gain=gamma.gain if isinstance(gamma, Linear) and _is_usable(gamma, usable_s) else None,
        change=BoundSum.of_chain(chain, decay, ratio_s),
    )


def held_power(system: System, passivity: Passivity, tank_j: ca.SX, held_s: float, *, general: bool = False) -> HeldRow:
    """Return the conditions on the power under a held input: for E ≥ E_r, or without a tank for h_u ≥ 0 all the time.

    With a tank p = E − E_r and q = Ė = h_u. Without one h_u(τ) ≥ h_u(0) + τ·(ḣ_u(0) − V) is to be at least 0.

    Args:
        system: The plant.
        passivity: Storage function and tank.
        tank_j: E, symbol, J.
        held_s: T, how long the input is held at most, s.
        general: Whether the symbols of the system's parameters stay in it.
    """
    if general:
        h_u = system.power - system.general_rate(passivity.V)
        rate = system.general_rate(h_u)
    else:
        h_u = power_margin(system, passivity.V)
        rate = system.rate(h_u)
    tank, value, p, bounds = passivity.tank, h_u, ca.SX(0), passivity.derivative_bounds
    ratio_s = held_s if tank is None else held_s / 2
    if tank is not None:
        p = tank_j - tank.reserve_j
        value = h_u + usable(Linear(gain=tank.rate_per_s), p, held_s)
    return HeldRow(
        value=value,
        bend=ratio_s * rate,
        p=p,
        usable_s=held_s,
        ratio_s=ratio_s,
        decay_per_s=0.0,
        q=h_u,
        continuous=passivity.V,
        gain=0.0,  # p does not depend on x
        change=None if bounds is None else BoundSum(bounds=bounds, weights=(0.0, ratio_s)),
    )


def _is_usable(gamma: ClassK, usable_s: float) -> bool:
    return isinstance(gamma, Linear) and gamma.gain * usable_s <= 1


def usable(gamma: ClassK, p: ca.SX, usable_s: float) -> ca.SX:
    """Return γ̃(p): γ(p), but no more than p/φ₁(T) for p > 0.

    A sampled input cannot use more: γ with a larger value lets p jump over zero before it ends.
    """
    value = gamma(p)
    if _is_usable(gamma, usable_s):
        return value
    return ca.if_else(p > 0, ca.fmin(value, p / usable_s), value)


def decay_rate(system: System, q: ca.SX, bend: ca.SX, held_s: float) -> float:
    """Return λ, 1/s: the rate at which u's direct effect on q fades by itself, 0 where that is slow beside T.

    It is −(∂q̇/∂u·∂q/∂u)/‖∂q/∂u‖², for which b depends least on u, and for a lagged drive about 1/lag.

    Args:
        system: The plant.
        q: ṗ, expression of x, u and t.
        bend: Its rate under a held input.
        held_s: T, s.
    """
    direct, fading = ca.gradient(q, system.u), ca.gradient(bend, system.u)
    both = ca.Function("both", [system.x, system.u, system.t], [ca.dot(fading, direct), ca.sumsqr(direct)])
    rates = []
    for k in range(PROBES):
        x, u = (np.sin(1.0 + 2.3 * np.arange(size) + k) for size in (system.n, system.m))
        change, square = map(float, both(x, u, 0.1 * k))
        rates.append(-change / square if square > 0 else 0.0)
    rate = float(np.median(rates))
    return rate if rate * held_s > SLOW else 0.0
