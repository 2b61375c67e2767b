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

from passafe.certificate import ResidualEvaluation, Tolerance, accepts
from passafe.numerics.fixed_order import product
from passafe.numerics.workspace import Array
from passafe.program.solvers.daqp_solver import DaqpSolver
from passafe.program.solvers.least_distance_solver import LeastDistanceSolver
from passafe.program.solvers.solver import SOLVED

ETA: Final = 1e-8
"""η: price of an input against that of a violation."""

ROOT: Final = sqrt(ETA)
LENGTH: Final = sqrt(1 + ETA)
"""√η, and the length of a hard row with its part of s."""

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


class LeastViolationSolver:
    """Finds the least relaxation of programs of one shape, in memory of its own."""

    def __init__(self, hard: int, limits: int, m: int) -> None:
        """Set the solvers up.

        Args:
            hard: H, rows that may be relaxed.
            limits: L, rows that may not.
            m: Inputs.
        """
        self._hard, self._m = hard, m
        self._rows, self._bounds = np.zeros((hard + limits, m + hard), order="F"), np.zeros(hard + limits)
        self._rows[:hard, m:] = np.eye(hard) * (ROOT / LENGTH)
        self._z, self._lam = np.zeros(m + hard), np.zeros(hard + limits)
        self._residuals = ResidualEvaluation(hard + limits, m + hard)
        self._solvers = tuple(kind(self._rows, self._bounds) for kind in (DaqpSolver, LeastDistanceSolver))

    def solve(self, G: Array, d: Array, limits_G: Array, limits_d: Array) -> LeastViolation | None:
        """Return the least relaxation, or ``None`` if no solver's answer passes the certificate.

        Args:
            G: Hard rows of unit length, shape (H, m).
            d: Their bounds, shape (H,).
            limits_G: Rows of the limits, never relaxed, shape (L, m).
            limits_d: Their bounds, shape (L,).
        """
        hard, m, rows, bounds, z, lam = self._hard, self._m, self._rows, self._bounds, self._z, self._lam
        rows[:hard, :m], rows[hard:, :m] = G / LENGTH, limits_G
        bounds[:hard], bounds[hard:] = d / LENGTH, limits_d
        for tolerance in (TIGHT, CROWDED):
            for solver in self._solvers:
                outcome = solver.solve(z.data, lam.data)
                if outcome is SOLVED and accepts(tolerance, self._residuals.of(rows, bounds, z, lam)):
                    needed = d - product(G, z[:m])
                    relaxed = np.where(needed > 0, needed + ROOM * (1 + np.abs(d)), 0.0)
                    return LeastViolation(relaxed, np.maximum(ETA * lam[hard:], 0.0))
        return None
