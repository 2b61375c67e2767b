"""PIQP as the filter's solver: set up once, then updated in place.

Its plain build is used on every processor: it is the fastest for the few rows of a filter, and builds for other
instruction sets round differently, so that a log would replay bit for bit on the same kind of processor only
(``docs/decisions/0005-plain-piqp.md``).
"""

from importlib import import_module
from typing import Final

import numpy as np

from passafe.numerics.workspace import Array
from passafe.program.solvers.solver import FAILED, INFEASIBLE, SOLVED, SolverOutcome

piqp = import_module("piqp.piqp_python")  # the package itself is one of its builds and hides the others


_SOLVED: Final = int(piqp.PIQP_SOLVED)
_INFEASIBLE: Final = int(piqp.PIQP_PRIMAL_INFEASIBLE)


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
        # Nearer to the boundary in one step: one iteration in four fewer, and as many answers pass the certificate.
        settings.tau = 0.999
        bound = np.full(rows, -1.0)
        self._solver.setup(np.eye(size), np.zeros(size), None, None, np.asfortranarray(G), bound, None, None, None)
        # Views on the solver's own memory, which stays where it is from now on; asking for them costs as much as
        # reading them.
        self._solver.solve()
        self._x, self._z_l = self._solver.result.x.data, self._solver.result.z_l.data

    def solve(self, z: memoryview, lam: memoryview) -> SolverOutcome:
        """Solve for the present G and d; see ``Solver.solve``. A NaN or an infeasible problem also fills ``z``."""
        solver = self._solver
        solver.update(None, None, None, None, self._G, self._d)
        status = int(solver.solve())
        z[:] = self._x
        lam[:] = self._z_l
        if status == _SOLVED:
            return SOLVED
        return INFEASIBLE if status == _INFEASIBLE else FAILED
