"""The filter's last solver: least-distance programming by non-negative least squares.

Lawson & Hanson (1974), chapter 23: with E = [Gᵀ; dᵀ] and f = (0, …, 0, 1), let y ≥ 0 minimise ‖E y − f‖ and
r = E y − f. If r = 0 the rows contradict one another and y proves it (Farkas); otherwise z = −r₁…ₖ / r₍ₖ₊₁₎. An
active-set method with orthogonal factorisations: slow, but it has nothing in common with the solvers before it.
"""

from typing import Final

import numpy as np

from passafe.numerics.fixed_order import inner, product
from passafe.numerics.workspace import Array
from passafe.program.solvers.nonnegative import nonnegative_least_squares
from passafe.program.solvers.solver import FAILED, INFEASIBLE, SOLVED, SolverOutcome

PROVEN: Final = 1e-12
"""Squared length of r from which the rows count as contradicting one another; rows are of unit length."""


class LeastDistanceSolver:
    """min ½‖z‖² subject to G z ≥ d, for arrays G and d that change in place.

    Attributes:
        name: How the certificate names it.
    """

    name = "ldp"

    def __init__(self, G: Array, d: Array) -> None:
        """Hold the arrays.

        Args:
            G: Rows, shape (N, k); read again at every solve.
            d: Bounds, shape (N,); read again at every solve.
        """
        self._G = G
        self._d = d

    def solve(self, z: memoryview, lam: memoryview) -> SolverOutcome:
        """Solve for the present G and d; see ``Solver.solve``."""
        # A bound of the order of one keeps the last row of E as long as the others: distances scale with d.
        scale = max(1.0, float(np.abs(self._d).max(initial=0.0)))
        E = np.vstack((self._G.T, self._d / scale))
        f = np.zeros(len(E))
        f[-1] = 1.0
        if not np.isfinite(E).all():
            return FAILED
        y = nonnegative_least_squares(E, f)
        if y is None:
            return FAILED
        r = product(E, y) - f
        if inner(r, r) <= PROVEN:
            lam[:] = y.data
            return INFEASIBLE
        if r[-1] == 0.0:  # underflow: the rows leave the nearest point beyond all numbers
            return FAILED
        z[:] = (r[:-1] * (-scale / r[-1])).data
        lam[:] = (y * (-scale / r[-1])).data
        return SOLVED
