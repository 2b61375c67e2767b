"""The attempts of a decision: rows, solution, certificate, and margins and tangents that suit the answer.

    rows → solve → certify → settle.

No answer is used that ``passafe.certificate`` does not accept, and none counts as settled whose margins between samples
or tangents were made for another input.
"""

from collections.abc import Callable
from math import inf
from typing import Final

import numpy as np

from passafe.answers.fixed_point import FixedPoint
from passafe.answers.slack_descent import SlackDescent, settled_but_for_slack
from passafe.certificate import accepts
from passafe.decision import ANSWERS, Attempt, Status
from passafe.decision_schema import Assessment, keeps_barriers
from passafe.design import FilterDesign
from passafe.numerics.fixed_order import length
from passafe.numerics.workspace import Array
from passafe.program.decision_block import DecisionBlock
from passafe.program.quadratic_program import ALL, BY_INSPECTION, QUICK, SLOW, QuadraticProgram
from passafe.program.solvers.solver import INFEASIBLE, SOLVED
from passafe.symbolic.decision_functions import DecisionFunctions
from passafe.symbolic.derivation import first_tightening
from passafe.symbolic.evaluation import SPARED
from passafe.symbolic.trust_region import LEAST_TRUST
from passafe.symbolic.whole_program import shape_tolerance

ATTEMPTS: Final = 14
"""Programs that are solved to settle margins and tangents, at most; the last margin is valid for every input."""

PLAIN_STEPS: Final = 3
"""Attempts that go straight to the answer before; then it is accelerated, for iterates may oscillate."""

CLOSER: Final = 0.5
NARROWER: Final = 0.1
"""The next trust radius, as a share of the way to the answer, or of the radius before."""

NARROWINGS: Final = 4
NEARER: Final = 0.25
"""Trust regions that are tried for nearer answers, and the next one's radius, as a share of the radius before."""

WORTHWHILE: Final = 1e-6
PROMISING: Final = 1e-3
"""Share by which an answer has to be nearer to be taken, and for narrower regions to be tried after its own."""

RELAXED_NORM: Final = 1e4
"""Factor on the norm's tolerance where hard rows are relaxed: there shortening costs little more."""

# Reaching a member through its enumeration takes 0.7 µs on Python 3.11, a tenth of a decision.
_PASSED: Final = Status.PASSED
_MODIFIED: Final = Status.MODIFIED
_RELAXED: Final = Status.RELAXED
_UNCERTIFIED: Final = Status.UNCERTIFIED
_INFEASIBLE: Final = Status.INFEASIBLE


class Attempts:
    """Attempts at the program of one ``DecisionBlock``, one after the other in the same memory."""

    def __init__(
        self,
        design: FilterDesign,
        block: DecisionBlock,
        functions: DecisionFunctions[Callable[[], None]],
        program: QuadraticProgram,
    ) -> None:
        """Hold what they are made with.

        Args:
            design: The filter's.
            block: Holds request, program and answer.
            functions: Bound to the block.
            program: Solves the program of the block.
        """
        self._block, self._functions, self._program = block, functions, program
        self._tolerance = design.tolerance
        self._relaxed_above = design.passivity.relaxed_above
        self._norm_tolerance = shape_tolerance(design.limits)
        self._first_tightening = first_tightening(design)
        self._least_trust: Array = LEAST_TRUST * np.array(design.limits.magnitude)
        self._reach = design.limits.reach
        self._descent = SlackDescent(design, block, self)

    def first(self, prepare: Callable[[], None]) -> Attempt:
        """Derive the rows, solve over the constraints and certify; if that is refused, solve the whole program."""
        block = self._block
        prepare()
        solver, outcome = self._program.solve_constraints()
        self._functions.evaluate()
        assessment = block.read_assessment()
        is_accepted = outcome is SOLVED and accepts(self._tolerance, assessment)
        if is_accepted and assessment.norm_overreach <= self._norm_tolerance:
            if assessment.concern <= 0.0:
                return Attempt(_PASSED if solver == BY_INSPECTION else _MODIFIED, solver, True, assessment)
            return self._answered(solver, assessment)
        if not block.program.nan_guard[0] <= 1.0:
            return Attempt(_UNCERTIFIED, solver, False, assessment)
        return self._attempt_whole()

    def confined(
        self, u_lin: Array, trust: Array, *, with_margins: bool = True, with_sets: bool = True, share: float = 1.0
    ) -> Attempt:
        """Attempt once about an input, with answers from its trust region only.

        The answer is the nearest one there. Where margins grow steeply with the input, programs that may leave the
        region lead to inputs whose own margins are too large. On the border of the region rounding may put an answer
        outside, unless a smaller share of it is asked for.
        """
        program = self._block.program
        self._linearize(u_lin, trust, with_margins=with_margins, with_sets=with_sets)

        def prepare() -> None:
            self._functions.prepare()
            np.maximum(program.low, u_lin - share * trust, out=program.low)
            np.minimum(program.high, u_lin + share * trust, out=program.high)

        return self.first(prepare)

    def nearer(self, attempt: Attempt) -> Attempt:
        """Look for answers nearer to the reference input, in ever narrower trust regions about the input before.

        A margin is for all of its trust region: where it grows steeply with the input, a wide region may leave none but
        answers that lead away from what was asked for. Where most of it is for what the state does anyway, a narrower
        region regains nothing, and the search ends.

        Args:
            attempt: A settled one, whose numbers are in the block.
        """
        block = self._block
        linearization, program, u_plus = block.linearization, block.program, block.evaluation.u_plus
        before = (linearization.u_lin.copy(), linearization.trust_asked.copy(), linearization.tightening.copy())
        nearest, best, u_best = self._distance(), None, u_plus.copy()
        trust, lost = program.trust.copy(), self._lost(attempt)
        for _ in range(NARROWINGS):
            still_lost, nearest_before = lost - SPARED * float(trust.max()), nearest
            trust, regained = np.maximum(NEARER * trust, self._least_trust), False
            for u_lin in (block.request.u.copy(), u_best):
                again = self.confined(u_lin, trust)
                distance = self._distance()
                regained = regained or self._lost(again) < still_lost
                if again.is_settled and distance < (1 - WORTHWHILE) * nearest:
                    nearest, best, u_best = distance, (u_lin, trust), u_plus.copy()
            if not regained and nearest > (1 - PROMISING) * nearest_before:
                break
            lost = self._lost(again)
        if best is not None:
            return self.confined(*best)
        return self.again(attempt, before)

    def again(self, attempt: Attempt, before: tuple[Array, Array, Array]) -> Attempt:
        """Make a settled attempt once more, from what margins and tangents it had: input, trust region, tightening."""
        linearization = self._block.linearization
        linearization.u_lin[:], linearization.trust_asked[:], linearization.tightening[:] = before
        again = self.first(self._functions.prepare)
        return Attempt(attempt.status, again.solver, True, again.assessment)

    def _lost(self, attempt: Attempt) -> float:
        """Return how far a margin may keep answers away by what is unknown alone, units of u."""
        return attempt.assessment.waste + SPARED * float(self._block.program.trust.max())

    def _distance(self) -> float:
        """Return ‖z‖: the distance of the answer from the reference input, the price of slack included."""
        return length(self._block.answer.z)

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
            return self._answered(solver, assessment)
        self._functions.prove_conflict()
        status = _INFEASIBLE if block.answer.conflict[0] > 0.0 else _UNCERTIFIED
        return Attempt(status, solver, False, assessment)

    def _answered(self, solver: str, assessment: Assessment[float]) -> Attempt:
        """Grade a certified answer that keeps every hard row as it was posed."""
        slack, relaxed_above = assessment.slack, self._relaxed_above
        kept = _PASSED if solver == BY_INSPECTION else _MODIFIED
        is_settled = (
            assessment.shortfall <= 0.0
            and assessment.outside_trust_region <= 0.0
            and assessment.unknown_margins <= 0.0
            and assessment.extra_slack <= relaxed_above
        )
        return Attempt(_RELAXED if slack > relaxed_above else kept, solver, is_settled, assessment)

    def _accepted_solver(self) -> str | None:
        """Return the solver whose answer to the whole program is accepted, relaxing the hard rows if there is none.

        Where one says that they conflict, that is proven or refuted before the last one is asked, which is slow.
        """
        solver, conflicts = self._first_accepted(QUICK)
        if solver is not None:
            return solver
        if not conflicts or not self._is_conflict():
            solver, _ = self._first_accepted(SLOW)
            if solver is not None or not self._program.relax_hard_rows():
                return solver
        return self._first_accepted(ALL)[0]

    def _first_accepted(self, solvers: slice) -> tuple[str | None, bool]:
        """Return the first solver whose answer is accepted, if any is, and whether the last says that rows conflict."""
        conflicts = False
        for solver, outcome in self._program.solve_whole(solvers):
            self._functions.evaluate()
            if outcome is SOLVED and accepts(self._tolerance, self._block.read_assessment()):
                return solver, False
            conflicts = outcome is INFEASIBLE
        return None, conflicts

    def _is_conflict(self) -> bool:
        """Relax the hard rows as little as they need, and return whether that proves a conflict; else undo it."""
        relax = self._block.answer.relax
        before = relax.copy()
        if self._program.relax_hard_rows():
            self._functions.prove_conflict()
            if self._block.answer.conflict[0] > 0.0:
                return True
        relax[:] = before
        return False

    def _is_short_enough(self) -> bool:
        overreach = self._block.read_assessment().norm_overreach
        return overreach <= self._norm_tolerance * (RELAXED_NORM if self._block.answer.relax.any() else 1.0)

    def settle(self, attempt: Attempt) -> Attempt:
        """Solve again with margins and tangents moved to the answer, until they suit it.

        Rows that conflict with a margin for a wide trust region, or with tangents far from the answer, need not
        conflict with nearer ones: then the trust region is narrowed, down to its least radius, and the tangents move
        half-way back. So do margins that are not known. Slack that the program did not count matters to none but the
        passivity row, which may have it: where nothing else is left to settle, the answer that takes the least is as
        good, and far better than one with the margin of every input.
        """
        linearization, least = self._block.linearization, self._least_trust
        least_slack, best = inf, (least, least, least[:1])
        u_lin, trust, u_plus = linearization.u_lin, linearization.trust_asked, self._block.evaluation.u_plus
        trust[:], before, answers = self._block.program.trust, u_lin.copy(), FixedPoint()
        for k in range(ATTEMPTS):
            if attempt.status is _UNCERTIFIED:
                return attempt
            if attempt.assessment.slack < least_slack and settled_but_for_slack(attempt):
                least_slack = attempt.assessment.slack
                best = (u_lin.copy(), trust.copy(), linearization.tightening.copy())
            if attempt.status is _INFEASIBLE or attempt.assessment.unknown_margins > 0.0:
                trust[:], answers = np.maximum(NARROWER * trust, least), FixedPoint()
                u_lin += (before - u_lin) / 2
            else:
                before = u_lin.copy()
                if attempt.assessment.outside_trust_region <= 0.0:
                    linearization.tightening[:] += 2 * max(attempt.assessment.shortfall, 0.0)
                u_lin[:] = answers.next(before, u_plus) if k >= PLAIN_STEPS else u_plus
                trust[:] = CLOSER * np.abs(u_plus - before).max() + least
            if k == ATTEMPTS - 1 and least_slack < inf:
                u_lin[:], trust[:], linearization.tightening[:] = best
            elif k == ATTEMPTS - 1 and attempt.status is not _INFEASIBLE:
                trust[:] = self._reach
            attempt = self.first(self._functions.prepare)
            gave_up = attempt.status is _INFEASIBLE and (trust <= least).all()
            if attempt.is_settled or gave_up:
                return self._descent.cheaper(attempt) if attempt.status is _RELAXED else attempt
        if attempt.status in ANSWERS and keeps_barriers(attempt.assessment):
            settled = Attempt(attempt.status, attempt.solver, True, attempt.assessment)
            return self._descent.cheaper(settled) if attempt.status is _RELAXED else settled
        return attempt

    def about(self, u_lin: Array, *, with_margins: bool, with_sets: bool = True) -> Attempt:
        """Start again with tangents and margins at another input."""
        self._linearize(u_lin, self._least_trust, with_margins=with_margins, with_sets=with_sets)
        attempt = self.first(self._functions.prepare)
        if attempt.is_settled or attempt.status is _INFEASIBLE:
            return attempt  # the trust region is the least already: the same program again would conflict again
        return self.settle(attempt)

    def _linearize(self, u_lin: Array, trust: Array, *, with_margins: bool, with_sets: bool) -> None:
        linearization = self._block.linearization
        linearization.u_lin[:], linearization.trust_asked[:] = u_lin, trust
        linearization.tightening[:] = self._first_tightening if with_margins else 0.0
        linearization.with_margins[:], linearization.with_sets[:] = with_margins, with_sets
