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

from passafe.arguments import numbers, one_number, vectors
from passafe.attempts import Attempts
from passafe.calmer_inputs import CalmerInputs
from passafe.decision import ANSWERS, Attempt, Decision, Status
from passafe.decision_block import DecisionBlock
from passafe.decision_functions import DecisionFunctions
from passafe.decision_schema import keeps_barriers
from passafe.derivation import Derivation
from passafe.design import FilterDesign, Law
from passafe.errors import ShapeError
from passafe.fallback import Fallback, between
from passafe.infeasibility import DistanceToInfeasibility
from passafe.input_search import InputSearch
from passafe.member_chains import design_chains
from passafe.plant_family import PlantFamily
from passafe.quadratic_program import QuadraticProgram
from passafe.symbolic.evaluation import UNPROTECTED
from passafe.symbolic.trust_region import LEAST_TRUST
from passafe.workspace import Array, BlockLayout

BACKUP: Final = "backup"
"""Name of the solver where the input is the backup law's."""

DEEPEST: Final = "deepest"
"""Name of the solver where the input is the one that keeps the hard rows best."""

BETWEEN: Final = "between"
"""Name of the solver where the input lies between the backup law's and another one, and keeps the barriers longest."""

_PLAIN: Final = (tuple, list)


class SafetyPassivityFilter:
    """Solves and certifies one quadratic program for every request.

    Attributes:
        design: What it was derived from.
        chains: Barrier chains, in the order of the design.
        derivation: The functions that it evaluates.
        compares_courses: Whether answers outside of the protected set are compared with the backup law.
    """

    def __init__(self, design: FilterDesign) -> None:
        """Derive and compile everything.

        Raises:
            DesignError: Some part of the design cannot be used.
        """
        self.design = design
        uncertainty = design.uncertainty
        family = None if uncertainty is None else PlantFamily.of(design, uncertainty)
        self.chains = tuple(design_chains(design, family))
        self.derivation = derivation = Derivation.of(design, self.chains, family)
        self._state_error = () if uncertainty is None else uncertainty.state_error or (0.0,) * design.system.n
        self._block = block = DecisionBlock(derivation.layout)
        self._functions: DecisionFunctions[Callable[[], None]] = DecisionFunctions.of(
            lambda name: block.space.bind(getattr(derivation.functions, name))
        )
        program = QuadraticProgram(block, derivation.rows, design.limits)
        self._attempts = Attempts(design, block, self._functions, program)
        self._attempt = self._attempts.first
        self._distance = DistanceToInfeasibility(design.limits, derivation.rows.hard)
        enforced = derivation.barriers
        self._input_search = None if derivation.is_affine else InputSearch(enforced)
        has_rollout = bool(enforced.chains) and design.law is Law.SAMPLED
        self._fallback = Fallback(design, enforced.chains) if has_rollout else None
        self.compares_courses = enforced.has_margins and has_rollout and family is None
        self._calmer_inputs = CalmerInputs(design)
        self._least_trust: Array = LEAST_TRUST * np.array(design.limits.magnitude)
        self._sizes = (design.system.n, *(design.system.m,) * 3)

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
        x_error: Sequence[float] | None = None,
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
            x_error: Largest error of each state, n numbers, state units; the design's ``uncertainty.state_error`` if it
                is not given. Only for a design with ``uncertainty``.

        Returns:
            A decision for any arguments, NaN and infinity included: its u is finite and within the
            limits, and its status shows whether it is certified.

        Raises:
            ShapeError: An argument of the wrong length, or that holds something that is no real number.
        """
        block, functions = self._block, self._functions
        error = self._state_error if x_error is None else self._given_error(x_error)
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
                block.write_request(*x, *u, *u_h, *u_h_rate, tank_j, t_s, start, *error)
            except struct.error:  # not all of them are plain numbers
                self._convert_request(x, u, u_h, u_h_rate, tank_j, t_s, start, error)
        else:
            self._convert_request(x, u, u_h, u_h_rate, tank_j, t_s, start, error)
        if is_start := bool(block.request.start[0]):
            functions.linearize()
        attempt = self._attempt(functions.prepare if is_start else functions.prepare_usual)
        if attempt.assessment.concern > 0.0 or not attempt.is_settled:
            attempt = self._reconsider(attempt)
        return self._decision(attempt)

    def _decision(self, attempt: Attempt) -> Decision:
        block = self._block
        return Decision(
            block.numbers.copy(),
            block.layout,
            attempt.status,
            attempt.solver,
            attempt.assessment,
            block.read_input(),
        )

    def _given_error(self, x_error: object) -> tuple[float, ...]:
        found = numbers("x_error", x_error)
        if len(found) != len(self._state_error):
            allowed = "a design with uncertainty" if not self._state_error else f"{len(self._state_error)} numbers"
            raise ShapeError("x_error", f"{len(found)} numbers", allowed)
        return found

    def _convert_request(
        self,
        x: object,
        u: object,
        u_h: object,
        u_h_rate: object,
        tank_j: object,
        t_s: object,
        start: object,
        error: Sequence[float],
    ) -> None:
        """Write a request that is not made of lists and tuples of floats; that takes longer than all the rest."""
        given = {"x": x, "u": u, "u_h": u_h, "u_h_rate": u_h_rate}
        scalars = {"tank_j": tank_j, "t_s": t_s, "start": start}
        found = chain.from_iterable(vectors(given, self._sizes))
        self._block.write_request(*found, *(one_number(field, value) for field, value in scalars.items()), *error)

    def _reconsider(self, attempt: Attempt) -> Attempt:
        """Settle what is not settled, resolve what cannot be, and guard what may lead to no good."""
        if not attempt.is_settled:
            attempt = self._attempts.settle(attempt)
        if not attempt.is_settled:
            attempt = self._resolve()
        elif attempt.assessment.waste > 0.0 and attempt.status is not Status.PASSED:
            attempt = self._attempts.nearer(attempt)
        if self.design.uncertainty is not None:
            return attempt  # rows hold for all members, the backup law's courses for the model alone
        is_unguarded = attempt.assessment.lowest_psi < UNPROTECTED or self.design.gatekeeper
        return self._guard(attempt) if is_unguarded and attempt.status in ANSWERS else attempt

    def _resolve(self) -> Attempt:
        """Find out what the hard rows allow where no answer is known to keep them with their margins, and act on it."""
        block, attempts = self._block, self._attempts
        if not block.program.nan_guard[0] <= 1.0:
            return self._send_backup(Attempt(Status.UNCERTIFIED, BACKUP, False, block.read_assessment()))
        at_samples = attempts.about(block.request.u, with_margins=False)
        if at_samples.status is Status.INFEASIBLE and self._input_search is not None:
            at_samples = self._search(at_samples, self._input_search)
        if at_samples.status in ANSWERS and not keeps_barriers(at_samples.assessment):  # tangents that do not settle
            at_samples = Attempt(Status.UNCERTIFIED, at_samples.solver, False, at_samples.assessment)
        if at_samples.status not in ANSWERS:
            return self._choose(at_samples)
        if not self.derivation.has_margins:
            return at_samples
        return self._with_margins(at_samples)

    def _with_margins(self, at_samples: Attempt) -> Attempt:
        """Return an answer that keeps the rows with their margins, sought from several inputs; else choose by course.

        Args:
            at_samples: The answer without margins, whose numbers are in the block.
        """
        block, attempts = self._block, self._attempts
        request, program = block.request, block.program
        u_sample, low, high = block.evaluation.u_plus.copy(), program.low.copy(), program.high.copy()
        deepest, of_all = self._deepest_input(at_samples), self._deepest_of_all()
        for u_lin in (u_sample, deepest, self._backup_input(), *of_all):
            again = attempts.about(u_lin, with_margins=True)
            if again.is_settled:
                return again
        for u_lin in of_all:  # where the rows are best their tangents are level, and keep no answer near
            again = attempts.confined(u_lin, self._least_trust)
            if again.is_settled:
                return again
        for wanted in (u_sample, deepest, *of_all):  # the second does not depend on the input before
            for u_lin, trust in self._calmer_inputs.towards(wanted, request.x, request.u, low, high):
                again = attempts.confined(u_lin, trust)
                if again.is_settled:
                    return again
        at_samples = self._at_samples(u_sample)
        return self._choose(Attempt(Status.AT_SAMPLES, at_samples.solver, False, at_samples.assessment))

    def _at_samples(self, u_lin: Array) -> Attempt:
        """Return the answer without margins that is found from an input, or near it.

        Where a drive saturates, rows lie level, and their tangents lead anywhere.
        """
        attempt = self._attempts.about(u_lin, with_margins=False)
        if attempt.status in ANSWERS and attempt.is_settled:
            return attempt
        return self._attempts.confined(u_lin, self._least_trust, with_margins=False)

    def _search(self, attempt: Attempt, search: InputSearch) -> Attempt:
        """Search all admissible inputs for one that keeps the hard rows, which are not affine in u.

        Tangents that conflict prove nothing of the rows themselves. Where the search neither finds an input nor proves
        that there is none, nothing is claimed.
        """
        found = search.find(self._block)
        if found.is_impossible:
            return attempt
        if found.u is not None and (again := self._at_samples(found.u)).status in ANSWERS:
            return again
        return Attempt(Status.UNCERTIFIED, attempt.solver, False, self._block.read_assessment())

    def _choose(self, attempt: Attempt) -> Attempt:
        """Send the answer of an attempt, unless another input or the backup law keeps the barriers longer.

        Where only the margins cannot be kept, but every barrier is proven to be kept on the course of what is sent,
        that is no fallback; nor is it where a gatekeeper has kept the robot to such courses.
        """
        block, fallback = self._block, self._fallback
        if fallback is None:
            return attempt if attempt.status is not Status.UNCERTIFIED else self._send_backup(attempt)
        if attempt.status is Status.UNCERTIFIED:
            return self._send_backup(attempt)
        candidates = [block.evaluation.u_plus.copy(), self._deepest_input(attempt)]
        request, others = block.request, len(candidates)
        candidates += between(self._backup_input(), candidates)
        best = fallback.best(request.x, float(request.t[0]), self._input_before(), candidates)
        if best.place is None:
            chosen = self._send_backup(attempt)
        elif best.place == 0:
            chosen = attempt
        else:
            chosen = self._send(candidates[best.place], DEEPEST if best.place < others else BETWEEN, attempt)
        is_proven = best.is_safe and (attempt.status is Status.AT_SAMPLES or self.design.gatekeeper)
        return _by_course(chosen) if is_proven else chosen

    def _guard(self, attempt: Attempt) -> Attempt:
        """Send an answer that keeps every row, unless the backup law's input is better.

        Outside of the protected set rows only lead back to it: there the answer is sent if no barrier is lost earlier
        on its course than on the backup law's, nor by more. Within it a gatekeeper sends an answer only if from where
        it leads the backup law keeps every barrier; where that law does not keep them either, nothing is guarded.
        """
        block, fallback = self._block, self._fallback
        if fallback is None:
            return attempt
        request, u_plus, before = block.request, block.evaluation.u_plus.copy(), self._input_before()
        state = request.x, float(request.t[0])
        if attempt.assessment.lowest_psi < UNPROTECTED:
            is_good = not self.compares_courses or fallback.best(*state, before, [u_plus]).place is not None
        else:
            is_good = fallback.is_backed(*state, u_plus) or not fallback.keeps(*state, before)
            is_good = is_good and (not fallback.keeps_late(*state, before) or fallback.is_backed_late(*state, u_plus))
        if is_good:
            return attempt
        return _by_course(self._send_backup(attempt))

    def _deepest_input(self, attempt: Attempt) -> Array:
        """Return the admissible input that keeps the hard rows best, as they are posed now, shape (m,)."""
        return self._distance.deepest(self._decision(attempt))

    def _deepest_of_all(self) -> list[Array]:
        """Return the admissible input that keeps rows best which are not affine in u: tangents may not lead to it."""
        return [] if self._input_search is None else [self._input_search.deepest(self._block)]

    def _input_before(self) -> Array:
        """Return the input from which the rate is limited; at the start, when none is, that is the backup law's own."""
        request = self._block.request
        return self._backup_input() if request.start[0] else request.u

    def _backup_input(self) -> Array:
        """Return the backup law's input, within the limits, shape (m,)."""
        block, limits = self._block, self.design.limits
        kept = block.evaluation.u_plus.copy()
        self._functions.fail_safe()
        law, program = block.evaluation.u_plus.copy(), block.program
        block.evaluation.u_plus[:] = kept
        return limits.nearest(law, block.request.u, program.low, program.high)

    def _send_backup(self, attempt: Attempt) -> Attempt:
        self._functions.prepare()  # an answer may have been confined to less than the limits
        return self._send(self._backup_input(), BACKUP, attempt)

    def _send(self, u_plus: Array, solver: str, attempt: Attempt) -> Attempt:
        """Put another input in the place of the answer and evaluate it; keep the answer's residuals as evidence."""
        block, evidence = self._block, attempt.assessment
        block.answer_numbers.fill(0.0)
        block.answer.z[: len(u_plus)] = u_plus - block.program.u_ref
        self._functions.evaluate()
        block.evaluation.u_plus[:] = u_plus
        residuals = block.residuals
        residuals.primal[:], residuals.dual[:], residuals.gap[:] = evidence.primal, evidence.dual, evidence.gap
        return Attempt(attempt.status, solver, False, block.read_assessment())


def _by_course(attempt: Attempt) -> Attempt:
    """Return an attempt whose input is sent because of its course."""
    return Attempt(Status.BACKUP, attempt.solver, True, attempt.assessment)
