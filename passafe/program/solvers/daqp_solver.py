"""DAQP, a dual active-set method, as the filter's second solver (Arnström, Bemporad & Axehill 2022)."""

from typing import Final

import daqp
import numpy as np

from passafe.numerics.workspace import Array
from passafe.program.solvers.solver import FAILED, INFEASIBLE, SOLVED, SolverOutcome

NO_BOUND: Final = 1e30
_SOLVED: Final = 1
_INFEASIBLE: Final = -1


class DaqpSolver:
    """min ½‖z‖² subject to G z ≥ d, for arrays G and d that change in place.

    Attributes:
        name: How the certificate names it.
    """

    name = "daqp"

    def __init__(self, G: Array, d: Array) -> None:
        """Set the solver up for the shapes of ``G`` and ``d``.

        Args:
            G: Rows, shape (N, k); read again at every solve.
            d: Bounds, shape (N,); read again at every solve.
        """
        rows, size = G.shape
        self._G = G
        self._d = d
        self._rows = np.ones((rows, size))
        self._above = np.full(rows, NO_BOUND)
        self._cold = np.zeros(rows, dtype=np.intc)
        self._model = daqp.Model()
        self._model.setup(np.eye(size), np.zeros(size), self._rows, self._above, np.full(rows, -1.0), self._cold)

    def solve(self, z: memoryview, lam: memoryview) -> SolverOutcome:
        """Solve for the present G and d; see ``Solver.solve``."""
        self._rows[:] = self._G
        # Fresh senses: otherwise it would start from the previous active set, and a log would not replay.
        updated = self._model.update(A=self._rows, bupper=self._above, blower=self._d, sense=self._cold)
        if updated < 0:
            return FAILED
        x, _, flag, info = self._model.solve()
        if flag != _SOLVED:  # what it leaves then is that of the problem before
            return INFEASIBLE if flag == _INFEASIBLE else FAILED
        z[:] = np.asarray(x, dtype=np.float64).data
        lam[:] = np.negative(info["lam"][-len(self._d) :], dtype=np.float64).data
        return SOLVED
