"""The safety and passivity filter: from a state and a request to a certified input.

Paper, proposition 2, with the rows of the chosen law. A decision is made in the order of this file:

    request → rows → solve → certify → settle → fall back.

``decide`` is a function of its arguments alone, and has an answer for all of them. What it keeps to, in this order:
a finite input within the limits; safety; passivity; what the operator asks for. The stages' numbers are declared in
``passafe.decision_schema``; every answer is accepted by ``passafe.certificate`` or not used.
"""

import struct
from collections.abc import Callable, Sequence
from itertools import chain
from typing import Final

import numpy as np

from passafe.arguments import one_number, vectors
from passafe.barrier_chain import derive_chains
from passafe.certificate import accepts
from passafe.decision import Attempt, Decision, Status
from passafe.decision_block import DecisionBlock
from passafe.decision_functions import DecisionFunctions
from passafe.derivation import Derivation
from passafe.design import FilterDesign
from passafe.quadratic_program import BY_INSPECTION, QuadraticProgram
from passafe.solvers.solver import SOLVED
from passafe.symbolic.trust_region import LEAST_TRUST
from passafe.symbolic.whole_program import shape_tolerance
from passafe.workspace import BlockLayout

ATTEMPTS: Final = 14
"""Programs that are solved to settle margins and tangents, at most; the last margin is valid for every input."""

FULL_STEPS: Final = 3
SHORT_STEP: Final = 0.6
"""After so many attempts they are moved only this share of the way to the answer: iterates may oscillate."""

CLOSER: Final = 0.5
NARROWER: Final = 0.1
"""The next trust radius, as a share of the way to the answer, or of the radius before."""

RELAXED_NORM: Final = 1e4
"""Factor on the norm's tolerance where hard rows are relaxed: there shortening costs little more."""

_PLAIN: Final = (tuple, list)

# Reaching a member through its enumeration takes 0.7 µs on Python 3.11, a tenth of a decision.
_PASSED: Final = Status.PASSED
_MODIFIED: Final = Status.MODIFIED
_RELAXED: Final = Status.RELAXED
_UNCERTIFIED: Final = Status.UNCERTIFIED
_INFEASIBLE: Final = Status.INFEASIBLE


class SafetyPassivityFilter:
    """Solves and certifies one quadratic program for every request.

    Attributes:
        design: What it was derived from.
        chains: Barrier chains, in the order of the design.
        derivation: The functions that it evaluates.
    """

    def __init__(self, design: FilterDesign) -> None:
        """Derive and compile everything.

        Raises:
            DesignError: Some part of the design cannot be used.
        """
        self.design = design
        self.chains = tuple(chain for barrier in design.barriers for chain in derive_chains(design.system, barrier))
        self.derivation = derivation = Derivation.of(design, self.chains)
        self._block = block = DecisionBlock(derivation.layout)
        self._functions: DecisionFunctions[Callable[[], None]] = DecisionFunctions.of(
            lambda name: block.space.bind(getattr(derivation.functions, name))
        )
        self._program = QuadraticProgram(block, derivation.rows, design.limits)
        self._tolerance = design.tolerance
        self._relaxed_above = design.passivity.relaxed_above
        self._sizes = (design.system.n, *(design.system.m,) * 3)
        self._norm_tolerance = shape_tolerance(design.limits)

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of the N rows, in the order of ``margins`` and ``duals``: constraints first, then limits."""
        return self.derivation.rows.names

    @property
    def constraints(self) -> int:
        """Number of rows that are constraints."""
        return self.derivation.rows.constraints

    @property
    def layout(self) -> BlockLayout:
        """Places of the parts in a decision's block."""
        return self.derivation.layout

    def decide(
        self,
        x: Sequence[float],
        u: Sequence[float],
        u_h: Sequence[float],
        u_h_rate: Sequence[float],
        tank_j: float = 0.0,
        t_s: float = 0.0,
        *,
        start: bool = False,
    ) -> Decision:
        """Return the input to hold over the next period.

        Args:
            x: State at which the input takes effect, n numbers: any sequence, a NumPy array or a ``casadi.DM``; with
                two axes, one of them of length one. Tuples and lists of floats are the fastest. The three below
                likewise, and for m = 1 a number.
            u: Input in force until then, m numbers.
            u_h: Operator's part of the input, m numbers.
            u_h_rate: Its time derivative, m numbers per second.
            tank_j: Energy E in the tank, J; without effect where the design has no tank.
            t_s: Plant time at which the input takes effect, s; without effect where no barrier moves.
            start: Whether there was no input before: then the answer is the one nearest to û that keeps every row,
                limits of the rate left out, instead of the one nearest to u + dt·φ.

        Returns:
            A decision for any arguments, NaN and infinity included: its u is finite and within the
            limits, and its status shows whether it is certified.

        Raises:
            ShapeError: An argument of the wrong length, or that holds something that is no real number.
        """
        block, functions = self._block, self._functions
        if (
            type(x) in _PLAIN
            and type(u) in _PLAIN
            and type(u_h) in _PLAIN
            and type(u_h_rate) in _PLAIN
            and type(tank_j) is type(t_s) is float
            and type(start) is bool
            and (len(x), len(u), len(u_h), len(u_h_rate)) == self._sizes
        ):
            try:
                block.write_request(*x, *u, *u_h, *u_h_rate, tank_j, t_s, start)
            except struct.error:  # not all of them are plain numbers
                self._convert_request(x, u, u_h, u_h_rate, tank_j, t_s, start)
        else:
            self._convert_request(x, u, u_h, u_h_rate, tank_j, t_s, start)
        if start:
            functions.linearize()
        attempt = self._attempt(functions.prepare if start else functions.prepare_usual)
        if attempt.status is _UNCERTIFIED:
            attempt = self._fall_back(attempt)
        elif not attempt.is_settled:
            attempt = self._settle(attempt)
            if attempt.status is _UNCERTIFIED:
                attempt = self._fall_back(attempt)
        return Decision(
            block.numbers.copy(),
            block.layout,
            attempt.status,
            attempt.solver,
            attempt.assessment,
            block.read_input(),
        )

    def _convert_request(
        self, x: object, u: object, u_h: object, u_h_rate: object, tank_j: object, t_s: object, start: object
    ) -> None:
        """Write a request that is not made of lists and tuples of floats; that takes longer than all the rest."""
        given = {"x": x, "u": u, "u_h": u_h, "u_h_rate": u_h_rate}
        scalars = {"tank_j": tank_j, "t_s": t_s, "start": start}
        numbers = chain.from_iterable(vectors(given, self._sizes))
        self._block.write_request(*numbers, *(one_number(field, value) for field, value in scalars.items()))

    def _attempt(self, prepare: Callable[[], None]) -> Attempt:
        """Derive the rows, solve over the constraints and certify; if that is refused, solve the whole program."""
        block = self._block
        prepare()
        solver, outcome = self._program.solve_constraints()
        self._functions.evaluate()
        assessment = block.read_assessment()
        is_accepted = outcome is SOLVED and accepts(self._tolerance, assessment)
        if is_accepted and assessment.norm_overreach <= self._norm_tolerance:
            if solver == BY_INSPECTION:
                status = _PASSED
            else:
                status = _RELAXED if assessment.slack > self._relaxed_above else _MODIFIED
            is_settled = assessment.shortfall <= 0.0 and assessment.outside_trust_region <= 0.0
            return Attempt(status, solver, is_settled, assessment)
        if not block.program.nan_guard[0] <= 1.0:
            return Attempt(_UNCERTIFIED, solver, False, assessment)
        return self._attempt_whole()

    def _attempt_whole(self) -> Attempt:
        """Solve over constraints and limits and certify; relax hard rows that conflict, as little as possible."""
        block, program = self._block, self._program
        program.add_limits()
        solver = self._accepted_solver()
        while solver is not None and not self._is_short_enough() and program.add_tangent():
            solver = self._accepted_solver()
        assessment = block.read_assessment()
        if solver is None or not self._is_short_enough():
            return Attempt(_UNCERTIFIED, solver or BY_INSPECTION, False, assessment)
        if not block.answer.relax.any():
            is_settled = assessment.shortfall <= 0.0 and assessment.outside_trust_region <= 0.0
            status = _RELAXED if assessment.slack > self._relaxed_above else _MODIFIED
            return Attempt(status, solver, is_settled, assessment)
        self._functions.prove_conflict()
        status = _INFEASIBLE if block.answer.conflict[0] > 0.0 else _UNCERTIFIED
        return Attempt(status, solver, not self.derivation.has_margins, assessment)

    def _accepted_solver(self) -> str | None:
        """Return the solver whose answer to the whole program is accepted, relaxing the hard rows if there is none."""
        solver = self._first_accepted()
        if solver is None and self._program.relax_hard_rows():
            solver = self._first_accepted()
        return solver

    def _first_accepted(self) -> str | None:
        for solver, outcome in self._program.solve_whole():
            self._functions.evaluate()
            if outcome is SOLVED and accepts(self._tolerance, self._block.read_assessment()):
                return solver
        return None

    def _is_short_enough(self) -> bool:
        overreach = self._block.read_assessment().norm_overreach
        return overreach <= self._norm_tolerance * (RELAXED_NORM if self._block.answer.relax.any() else 1.0)

    def _settle(self, attempt: Attempt) -> Attempt:
        """Solve again with margins and tangents moved to the answer, until they suit it.

        Rows that conflict with a margin for a wide trust region, or with tangents far from the answer, need not
        conflict with nearer ones: then the trust region is narrowed, down to its least radius, and the tangents move
        half-way back.
        """
        linearization, least = self._block.linearization, LEAST_TRUST * np.array(self.design.limits.magnitude)
        u_lin, trust, u_plus = linearization.u_lin, linearization.trust_asked, self._block.evaluation.u_plus
        trust[:], before = self._block.program.trust, u_lin.copy()
        for k in range(ATTEMPTS):
            if attempt.status is _INFEASIBLE:
                trust[:] = np.maximum(NARROWER * trust, least)
                u_lin += (before - u_lin) / 2
            else:
                before = u_lin.copy()
                if attempt.assessment.outside_trust_region <= 0.0:
                    linearization.tightening[:] += 2 * attempt.assessment.shortfall
                change = u_plus - u_lin
                trust[:] = CLOSER * np.abs(change).max() + least
                u_lin += change if k < FULL_STEPS else SHORT_STEP * change
            if k == ATTEMPTS - 1 and attempt.status is not _INFEASIBLE:
                trust[:] = self.design.limits.reach
            attempt = self._attempt(self._functions.prepare)
            gave_up = attempt.status is _INFEASIBLE and (trust <= least).all()
            if attempt.is_settled or attempt.status is _UNCERTIFIED or gave_up:
                return attempt
        if attempt.status is _INFEASIBLE:
            return attempt
        return Attempt(_UNCERTIFIED, attempt.solver, False, attempt.assessment)

    def _fall_back(self, attempt: Attempt) -> Attempt:
        """Replace the answer by the fail-safe law's input and evaluate that; keep the residuals as evidence."""
        block, functions, evidence = self._block, self._functions, attempt.assessment
        functions.fail_safe()
        program = block.program
        u_plus = self.design.limits.nearest(block.evaluation.u_plus, block.request.u, program.low, program.high)
        block.answer_numbers.fill(0.0)
        block.answer.z[: len(u_plus)] = u_plus - program.u_ref
        functions.evaluate()
        block.evaluation.u_plus[:] = u_plus
        residuals = block.residuals
        residuals.primal[:], residuals.dual[:], residuals.gap[:] = evidence.primal, evidence.dual, evidence.gap
        return Attempt(_UNCERTIFIED, attempt.solver, False, block.read_assessment())
