"""The filter's quadratic program and the certificate of its answers.

Every law and mode comes down to one form: the point nearest to the origin in a polyhedron,

    min ½‖z‖²  subject to  G z ≥ d,

with rows of unit length, so that residuals and row margins are distances in units of u. The first m entries of
z are u⁺ − u_ref; the passivity row's slack, scaled by √ρ_u so that its cost is also ½z², is the last one.
"""

from dataclasses import dataclass

import casadi as ca

from passafe.workspace import dense_function

PRIMAL, DUAL, GAP = range(3)
"""Places of the three residuals in the certificate's vector."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tolerance:
    """Residuals up to which an answer is accepted, relative to 1 + ‖z‖ (gap: 1 + ‖z‖²).

    Attributes:
        residual: Largest primal and dual residual.
        gap: Largest duality gap. A feasible z then lies within √(2·gap) of the true minimiser, because the
            objective is strongly convex with modulus 1.
    """

    residual: float = 1e-6
    gap: float = 1e-6


def certificate_residuals(z: ca.SX, lam: ca.SX, G: ca.SX, d: ca.SX) -> ca.SX:
    """Return the three relative residuals of the optimality conditions, shape (3, 1).

    * primal: largest violation of G z ≥ d, over 1 + ‖z‖;
    * dual: largest of |z − Gᵀλ| and of −λ, over 1 + ‖z‖;
    * gap: |½zᵀz − (λᵀd − ½‖Gᵀλ‖²)| over 1 + ‖z‖² (Boyd & Vandenberghe, section 5.5).

    All three vanish exactly at the minimiser and its multipliers. A NaN in any argument makes one of them NaN,
    which no comparison accepts.

    Args:
        z: Decision, shape (k, 1).
        lam: Multipliers λ, shape (N, 1).
        G: Rows, shape (N, k).
        d: Bounds, shape (N, 1).
    """
    if d.numel() == 0:
        return ca.vertcat(0, ca.norm_2(z), ca.sumsqr(z))
    scale = 1 + ca.norm_2(z)
    pull = G.T @ lam
    primal = ca.fmax(ca.mmax(d - G @ z), 0) / scale
    dual = ca.fmax(ca.mmax(ca.fabs(z - pull)), -ca.mmin(lam)) / scale
    gap = ca.fabs(ca.sumsqr(z) / 2 - ca.dot(lam, d) + ca.sumsqr(pull) / 2) / (1 + ca.sumsqr(z))
    return ca.vertcat(primal, dual, gap)


def judging_function(rows: int, size: int) -> ca.Function:
    """Return the function (G, d, z, λ) → (margins G z − d, residuals) for ``rows`` rows of length ``size``."""
    G = ca.SX.sym("G", rows, size)
    d = ca.SX.sym("d", rows)
    z = ca.SX.sym("z", size)
    lam = ca.SX.sym("lam", rows)
    return dense_function("judge", [G, d, z, lam], [G @ z - d, certificate_residuals(z, lam, G, d)])
