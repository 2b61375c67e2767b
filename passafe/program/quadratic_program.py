"""The filter's quadratic program, and where it is solved.

Every law and mode comes down to one form: the point nearest to the origin in a polyhedron,

    min ½‖z‖²  subject to  G z ≥ d,

with rows of unit length, so that residuals and row margins are distances in units of u. The first m entries of
z are u⁺ − u_ref; the passivity row's slack, scaled by √ρ_u so that its cost is also ½z², is the last one.

It is first solved over the constraints alone. Only where that answer is beyond the limits of the input is the whole
program solved, limits included.
"""

from collections.abc import Iterator
from typing import Final, cast

import numpy as np

from passafe.limits import Limits
from passafe.numerics.fixed_order import product
from passafe.numerics.workspace import Array
from passafe.program.decision_block import DecisionBlock
from passafe.program.norm_tangents import norm_tangents
from passafe.program.solvers.daqp_solver import DaqpSolver
from passafe.program.solvers.least_distance_solver import LeastDistanceSolver
from passafe.program.solvers.least_violation import LeastViolationSolver
from passafe.program.solvers.piqp_solver import PiqpSolver
from passafe.program.solvers.solver import SOLVED, Solver, SolverOutcome
from passafe.symbolic.whole_program import RowLayout, limit_bounds

BY_INSPECTION: Final = "none"
"""Name of the solver where z = 0 is optimal because no constraint asks for anything."""

ALL, QUICK, SLOW = slice(None), slice(2), slice(2, None)
"""Solvers of the whole program: the last of them takes as long as a dozen of the others."""


class QuadraticProgram:
    """Solves the program of a ``DecisionBlock`` and writes the answer into it.

    No answer is judged here, and none is trusted: see ``passafe.certificate``.
    """

    def __init__(self, block: DecisionBlock, rows: RowLayout, limits: Limits) -> None:
        """Set the solvers up.

        Args:
            block: Holds the program and receives the answers.
            rows: Of the whole program.
            limits: The filter's.
        """
        self._block, self._rows, self._norms = block, rows, norm_tangents(limits)
        weights, asked, lengths = limit_bounds(limits)
        self._weights: Array = weights.full()
        self._asked, self._lengths = asked.full().ravel(), lengths.full().ravel()
        answer, program, m = block.answer, block.program, len(block.program.u_ref)
        self._z, self._lam = answer.z.data, answer.lam.data
        self._largest_bound = cast("memoryview[float]", program.largest_bound.data)
        self._constraint_lam = answer.lam[: rows.constraints].data
        self._constraint_solver = PiqpSolver(program.G, program.d) if rows.constraints else None
        # The whole program: constraints, then ±z of the first m axes, half-spaces, tangents of the norms.
        self._G, self._d = np.zeros((len(rows.names), rows.columns), order="F"), np.zeros(len(rows.names))
        fixed = np.vstack((np.eye(m), -np.eye(m), -self._weights))
        self._G[rows.constraints : rows.constraints + len(fixed), :m] = fixed
        self._least_violation = LeastViolationSolver(rows.hard, len(self._d) - rows.constraints, m)
        self._solvers: tuple[Solver, ...] = tuple(
            kind(self._G, self._d) for kind in (PiqpSolver, DaqpSolver, LeastDistanceSolver)
        )

    def solve_constraints(self) -> tuple[str, SolverOutcome]:
        """Solve over the constraints alone; return the solver's name and the outcome that it reports.

        The answer is blank before: where no constraint asks for anything it stays so.
        """
        solver = self._constraint_solver
        if solver is None or not self._largest_bound[0] > 0.0:
            return BY_INSPECTION, SOLVED
        return solver.name, solver.solve(self._z, self._constraint_lam)

    def solve_whole(self, solvers: slice) -> Iterator[tuple[str, SolverOutcome]]:
        """Solve over constraints and limits, hard rows relaxed by ``relax``, with one solver after the other.

        Args:
            solvers: ``ALL``, the ``QUICK`` ones or the ``SLOW`` one.
        """
        hard = self._rows.hard
        self._d[:hard] = self._block.program.d[:hard] - self._block.answer.relax
        for solver in self._solvers[solvers]:
            yield solver.name, solver.solve(self._z, self._lam)

    def add_limits(self) -> None:
        """Write the whole program, with the tangents that there are."""
        constraints = self._rows.constraints
        self._G[:constraints], self._d[:constraints] = self._block.program.G, self._block.program.d
        for norm in self._norms:
            norm.used = 0
        self._write_limits()

    def add_tangent(self) -> bool:
        """Put tangents of the norms' limits where the present answer is beyond them; return whether any was put."""
        u_ref = self._block.program.u_ref
        unclipped = u_ref + self._block.answer.z[: len(u_ref)]
        cut = [norm.cut(self._block.tangents.cuts, unclipped) for norm in self._norms]
        if not any(cut):
            return False
        self._write_limits()
        return True

    def relax_hard_rows(self) -> bool:
        """Relax hard rows as little as the limits allow; return whether that has a certified answer."""
        rows, program = self._rows, self._block.program
        hard, limits, m = slice(rows.hard), slice(rows.constraints, None), len(program.u_ref)
        least = self._least_violation.solve(self._G[hard, :m], program.d[hard], self._G[limits, :m], self._d[limits])
        if least is None:
            return False
        self._block.answer.relax[:] = least.rows
        self._block.answer.limit_weights[:] = least.limit_weights[2 * m :]
        return True

    def _write_limits(self) -> None:
        program, cuts = self._block.program, self._block.tangents.cuts
        first, m = self._rows.constraints, len(program.u_ref)
        self._d[first : first + m] = program.low - program.u_ref
        self._d[first + m : first + 2 * m] = program.u_ref - program.high
        if len(self._asked):
            planes = slice(first + 2 * m, first + 2 * m + len(self._asked))
            self._d[planes] = product(self._weights, program.u_ref) - self._asked
        if len(cuts):
            tangents = slice(first + 2 * m + len(self._asked), None)
            self._G[tangents, :m] = -cuts
            self._d[tangents] = product(cuts, program.u_ref) - self._lengths
