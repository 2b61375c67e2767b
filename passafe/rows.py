"""The rows of the quadratic program, derived from the barrier chains and the power margin.

A row is first written as c + gᵀw + δ·[soft] ≥ 0 in w = u⁺ − u_ref, then scaled to unit length.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import casadi as ca

from passafe.barrier import BarrierChain
from passafe.class_k import ClassK
from passafe.passivity import Passivity
from passafe.system import System

PASSIVITY_ROW = "passivity"
"""Name of the passivity row beside the barriers' names."""

TINY = 1e-12
"""A gradient shorter than this counts as zero: its row is either kept whatever u is, or cannot be kept."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Row:
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


def sampled_rows(
    system: System,
    chains: Sequence[BarrierChain],
    h_u: ca.SX | None,
    passivity: Passivity | None,
    u_ref: ca.SX,
    tank_j: ca.SX,
) -> list[Row]:
    """Return the rows of the sampled law: ψ_r(x, u⁺) ≥ 0, and h_u(x, u⁺) ≥ −κ(E − E_r) − δ, in w.

    For dynamics affine in u both are affine in w; otherwise they are linearised at u_ref.

    Args:
        system: The plant.
        chains: One for each barrier.
        h_u: Power margin, or ``None`` where passivity is not asked for.
        passivity: Goes with ``h_u``.
        u_ref: Where w is zero, expression, shape (m, 1).
        tank_j: E, symbol, J.
    """
    rows = [
        Row(name=chain.barrier.name, value=value, gradient=gradient)
        for chain in chains
        for value, gradient in [_at(system, chain.psi[-1], u_ref)]
    ]
    if h_u is not None and passivity is not None:
        value, gradient = _at(system, h_u, u_ref)
        if passivity.tank is not None:
            value += passivity.tank.rate_per_s * (tank_j - passivity.tank.reserve_j)
        rows.append(Row(name=PASSIVITY_ROW, value=value, gradient=gradient, slack_price=passivity.slack_weight))
    return rows


def continuous_rows(
    system: System,
    chains: Sequence[BarrierChain],
    h_u: ca.SX | None,
    passivity: Passivity | None,
    phi: ca.SX,
    dt_s: float,
) -> list[Row]:
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


def stack(rows: Sequence[Row], m: int, reach: float) -> tuple[ca.SX, ca.SX, float]:
    """Return (G, d, √ρ) of G z ≥ d with rows of unit length; √ρ is 0 where no row is soft.

    A bound further away than any input can go, ``reach``, is drawn in to it: a row that always holds goes on
    holding and a hard row that cannot hold goes on failing, but no number is left for the solver to choke on.

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


def _at(system: System, function: ca.SX, u_ref: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Value and input gradient of a function of (x, u) at u = u_ref."""
    gradient = ca.gradient(function, system.u)
    value_there, gradient_there = ca.substitute([function, gradient], [system.u], [u_ref])
    return value_there, gradient_there


def _rate_row(system: System, name: str, function: ca.SX, gamma: ClassK, phi: ca.SX, dt_s: float) -> Row:
    """Row of d/dt function + γ(function) ≥ 0 along ẋ = f, u̇ = φ + v, times dt."""
    gradient = ca.gradient(function, system.u)
    drift = system.rate(function) + ca.dot(gradient, phi) + gamma(function)
    return Row(name=name, value=dt_s * drift, gradient=gradient)
