"""Relaxes hard rows that contradict one another or the limits, as little as possible.

min ½‖s‖² + ½η‖w‖² subject to G w + s ≥ d and w within the limits: s is the violation of each row. With η as
small as it is, s exceeds the least possible by no more than √η·‖w‖. The s that solves it is also its own multiplier,
hence Farkas' proof that the rows cannot be kept (``passafe.symbolic.conflict_proof``). Second step of a lexicographic
programme: the ordinary quadratic program then follows with d − s in the place of d.
"""

from math import sqrt
from typing import Final

import numpy as np
from msgspec import Struct

from passafe.certificate import Tolerance, accepts, residuals_of
from passafe.fixed_order import product
from passafe.solvers.daqp_solver import DaqpSolver
from passafe.solvers.least_distance_solver import LeastDistanceSolver
from passafe.solvers.solver import SOLVED
from passafe.workspace import Array

ETA: Final = 1e-8
"""η: price of an input against that of a violation."""

TIGHT: Final = Tolerance(residual=1e-9, gap=1e-9)
"""Residuals up to which an answer is accepted: tighter than elsewhere, because z holds s/√η beside w."""

CROWDED: Final = Tolerance(residual=1e-9, gap=1e-7)
"""The same where tangents lie close together: their multipliers nearly cancel, and the gap is their rounding."""

ROOM: Final = 1e-9
"""Relaxation beyond the needed one, so that rounding leaves the relaxed program feasible."""


class LeastViolation(Struct, frozen=True, eq=False):
    """The least relaxation, and the multipliers of the limits that go with it.

    Attributes:
        rows: s ≥ 0 of the hard rows, shape (H,).
        limit_weights: ν ≥ 0 of the limits in the same measure, shape (L,): Gᵀs + Lᵀν = ηw, nearly nothing.
    """

    rows: Array
    limit_weights: Array


def least_violation(G: Array, d: Array, limits_G: Array, limits_d: Array) -> LeastViolation | None:
    """Return the least relaxation, or ``None`` if no solver's answer passes the certificate.

    Args:
        G: Hard rows of unit length, shape (H, m).
        d: Their bounds, shape (H,).
        limits_G: Rows of the limits, never relaxed, shape (L, m).
        limits_d: Their bounds, shape (L,).
    """
    hard, m = G.shape
    root = sqrt(ETA)
    length = sqrt(1 + ETA)
    rows = np.zeros((hard + len(limits_d), m + hard), order="F")
    rows[:hard, :m] = G / length
    rows[:hard, m:] = np.eye(hard) * (root / length)
    rows[hard:, :m] = limits_G
    bounds = np.concatenate((d / length, limits_d))
    z, lam = np.zeros(m + hard), np.zeros(len(bounds))
    for tolerance in (TIGHT, CROWDED):
        for kind in (DaqpSolver, LeastDistanceSolver):
            outcome = kind(rows, bounds).solve(z.data, lam.data)
            if outcome is SOLVED and accepts(tolerance, residuals_of(rows, bounds, z, lam)):
                needed = d - product(G, z[:m])
                relaxed = np.where(needed > 0, needed + ROOM * (1 + np.abs(d)), 0.0)
                return LeastViolation(relaxed, np.maximum(ETA * lam[hard:], 0.0))
    return None
