"""PIQP as the filter's solver: set up once, then updated in place."""

from enum import Enum

import numpy as np
import piqp

from passafe.workspace import Array


class SolverOutcome(Enum):
    """What the solver says of its own answer; the certificate decides whether it is used."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    FAILED = "failed"


SOLVED, INFEASIBLE, FAILED = SolverOutcome

_SOLVED = int(piqp.PIQP_SOLVED)
_INFEASIBLE = int(piqp.PIQP_PRIMAL_INFEASIBLE)


class PiqpSolver:
    """min ½‖z‖² subject to G z ≥ d, for arrays G and d that change in place.

    Attributes:
        name: How the certificate names it.
    """

    name = "piqp"

    def __init__(self, G: Array, d: Array) -> None:
        """Set the solver up for the shapes of ``G`` and ``d``.

        Args:
            G: Rows, shape (N, k), Fortran-ordered; read again at every solve.
            d: Bounds, shape (N,); read again at every solve.
        """
        rows, size = G.shape
        self._G = G
        self._d = d
        self._solver = piqp.DenseSolver()
        settings = self._solver.settings
        settings.verbose = False
        # Rows are of unit length and the cost is the identity: nothing is left to precondition, and without it
        # an answer does not depend on the problem solved before.
        settings.preconditioner_iter = 0
        bound = np.full(rows, -1.0)
        self._solver.setup(np.eye(size), np.zeros(size), None, None, np.asfortranarray(G), bound, None, None, None)

    def solve(self, z: Array, lam: Array) -> SolverOutcome:
        """Solve for the present G and d.

        Args:
            z: Receives the decision, shape (k,). Whatever the outcome, it may hold anything.
            lam: Receives the multipliers, shape (N,).

        Returns:
            What the solver says. A NaN or an infeasible problem also fills ``z``.
        """
        solver = self._solver
        solver.update(None, None, None, None, self._G, self._d)
        status = int(solver.solve())
        result = solver.result
        z[:] = result.x
        lam[:] = result.z_l
        if status == _SOLVED:
            return SOLVED
        return INFEASIBLE if status == _INFEASIBLE else FAILED
