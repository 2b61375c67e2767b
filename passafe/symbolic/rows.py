"""The rows of the quadratic program, derived from the barrier chains and the power margin.

A row is first written as c + gᵀw + δ·[soft] ≥ 0 in w = u⁺ − u_ref, then scaled to unit length.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.class_k import ClassK
from passafe.passivity import Passivity
from passafe.system import System

PASSIVITY_ROW = "passivity"
"""Name of the passivity row beside the barriers' names."""

TINY = 1e-12
"""A gradient shorter than this counts as zero: its row is either kept whatever u is, or cannot be kept."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class ConstraintRow:
    """c + gᵀw + slack ≥ 0.

    Attributes:
        name: The barrier's name, or ``passivity``.
        value: c, the row's function at w = 0, scalar.
        gradient: g, shape (m, 1).
        slack_price: ρ_u of a soft row; ``None`` for a hard one.
    """

    name: str
    value: ca.SX
    gradient: ca.SX
    slack_price: float | None = None


def row_at(system: System, name: str, function: ca.SX, u_ref: ca.SX, u_lin: ca.SX) -> ConstraintRow:
    """Return the row function(x, u⁺) ≥ 0 of the sampled law, in w: exact if it is affine in u, else its tangent.

    Args:
        system: The plant.
        name: The row's name.
        function: Scalar expression of the system's x, u and t.
        u_ref: Where w is zero, expression, shape (m, 1).
        u_lin: Where the tangent touches, expression, shape (m, 1).
    """
    gradient = ca.gradient(function, system.u)
    if not ca.depends_on(gradient, system.u):
        return ConstraintRow(name=name, value=ca.substitute(function, system.u, u_ref), gradient=gradient)
    value, slope = ca.substitute([function, gradient], [system.u], [u_lin])
    return ConstraintRow(name=name, value=value + ca.dot(slope, u_ref - u_lin), gradient=slope)


def continuous_rows(
    system: System,
    chains: Sequence[BarrierChain],
    h_u: ca.SX | None,
    passivity: Passivity | None,
    phi: ca.SX,
    dt_s: float,
) -> list[ConstraintRow]:
    """Return the paper's rows, all hard: ψ̇_r(x, u, φ + v) + γ(ψ_r) ≥ 0 and ḣ_u + γ_u(h_u) ≥ 0, in w = dt·v.

    Args:
        system: The plant.
        chains: One for each barrier.
        h_u: Power margin, or ``None`` where passivity is not asked for.
        passivity: Goes with ``h_u``.
        phi: Tracking term φ, expression, shape (m, 1).
        dt_s: Period, s.
    """
    rows = [_rate_row(system, chain.barrier.name, chain.psi[-1], chain.last_class_k, phi, dt_s) for chain in chains]
    if h_u is not None and passivity is not None:
        rows.append(_rate_row(system, PASSIVITY_ROW, h_u, passivity.class_k, phi, dt_s))
    return rows


def stack(rows: Sequence[ConstraintRow], m: int, reach: float) -> tuple[ca.SX, ca.SX, float]:
    """Return (G, d, √ρ) of G z ≥ d with rows of unit length; √ρ is 0 where no row is soft.

    A bound further away than any input can go, ``reach``, is drawn in to it: a row that always holds still
    holds and a hard row that cannot hold still fails, but the solver meets no huge numbers.

    Args:
        rows: At most one of them soft.
        m: Number of inputs.
        reach: Longest w between two admissible inputs, units of u.
    """
    root = max((sqrt(row.slack_price) for row in rows if row.slack_price is not None), default=0.0)
    size = m + (1 if root else 0)
    G, d = [], []
    for row in rows:
        slack = [] if not root else [1 / root if row.slack_price is not None else 0.0]
        full = ca.vertcat(row.gradient, *slack)
        length = ca.fmax(ca.norm_2(full), TINY)
        bound = ca.fmax(-row.value / length, -2 * reach)
        G.append((full / length).T)
        d.append(bound if row.slack_price is not None else ca.fmin(bound, 2 * reach))
    return ca.vertcat(ca.SX(0, size), *G), ca.vertcat(ca.SX(0, 1), *d), root


def _rate_row(system: System, name: str, function: ca.SX, gamma: ClassK, phi: ca.SX, dt_s: float) -> ConstraintRow:
    """Return the row d/dt function + γ(function) ≥ 0 along ẋ = f, u̇ = φ + v, times dt."""
    gradient = ca.gradient(function, system.u)
    drift = system.rate(function) + ca.dot(gradient, phi) + gamma(function)
    return ConstraintRow(name=name, value=dt_s * drift, gradient=gradient)
