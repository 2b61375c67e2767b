"""The safety and passivity filter: from a state and a request to a certified input.

Paper, proposition 2, with the rows of the chosen law. A decision is made in this order:

    request → rows → solve → certify → settle → resolve → guard.

``decide`` is a function of its arguments alone, and has an answer for all of them. What it keeps to, in this order:
a finite input within the limits; safety; passivity; what the operator asks for. The stages' numbers are declared in
``passafe.decision_schema``; every answer is accepted by ``passafe.certificate`` or not used.
"""

import struct
from collections.abc import Callable, Sequence
from itertools import chain
from threading import RLock
from typing import Final

from passafe.answers.attempts import Attempts
from passafe.answers.course_choice import CourseChoice
from passafe.answers.deepest_inputs import DeepestInputs
from passafe.answers.input_search import InputSearch
from passafe.answers.replaced_answer import ReplacedAnswer
from passafe.answers.resolution import Resolution
from passafe.arguments.numbers import described, numbers, one_number, vectors
from passafe.courses.fallback import Fallback
from passafe.decision import ANSWERS, Attempt, Decision, Status
from passafe.design import FilterDesign, Law
from passafe.errors import DesignError, ShapeError
from passafe.margins.member_chains import design_chains
from passafe.margins.plant_family import PlantFamily
from passafe.numerics.workspace import BlockLayout, Compiler, interpreted
from passafe.program.decision_block import DecisionBlock
from passafe.program.infeasibility import DistanceToInfeasibility
from passafe.program.quadratic_program import QuadraticProgram
from passafe.symbolic.decision_functions import DecisionFunctions
from passafe.symbolic.derivation import Derivation
from passafe.symbolic.evaluation import UNPROTECTED

_PLAIN: Final = (tuple, list)


class SafetyPassivityFilter:
    """Solves and certifies one quadratic program for every request.

    Attributes:
        design: What it was derived from.
        chains: Barrier chains, in the order of the design.
        derivation: The functions that it evaluates.
        compares_courses: Whether answers outside of the protected set are compared with the backup law.
        rollout: Rolls the fail-safe law out; ``None`` without enforced barriers or the sampled law.
    """

    def __init__(self, design: FilterDesign, *, compiler: Compiler = interpreted) -> None:
        """Derive and compile everything.

        Args:
            design: The design.
            compiler: Compiles what courses are rolled out with, which takes most of a decision's time where there is a
                gatekeeper; what it returns must give the same numbers to the last bit.

        Raises:
            DesignError: Some part of the design cannot be used.
        """
        if not isinstance(design, FilterDesign):
            raise DesignError("design", described(design), "a FilterDesign")
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
        enforced = derivation.barriers
        replaced = ReplacedAnswer(design.limits, block, self._functions)
        search = None if derivation.is_affine else InputSearch(enforced)
        deepest = DeepestInputs(block, DistanceToInfeasibility(design.limits, derivation.rows.hard), search)
        has_rollout = bool(enforced.chains) and design.law is Law.SAMPLED
        fallback = Fallback(design, enforced.chains, compiler) if has_rollout else None
        self.rollout = None if fallback is None else fallback.rollout
        compares = enforced.has_margins and family is None
        self._choice = CourseChoice(
            block, replaced, deepest, fallback, compares=compares, is_for_sets=family is not None
        )
        self.compares_courses = self._choice.compares
        self._resolution = Resolution(design, block, self._attempts, replaced, deepest, self._choice)
        self._sizes = (design.system.n, *(design.system.m,) * 3)
        self._one_at_a_time = RLock()

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
        """Return the input to hold over the next period; threads that ask at once wait for one another.

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
        with self._one_at_a_time:
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
            return block.decision(attempt)

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
            attempt = self._resolution.resolve(has_margins=self.derivation.has_margins)
        elif attempt.assessment.waste > 0.0 and attempt.status is not Status.PASSED:
            attempt = self._attempts.nearer(attempt)
        if self.design.uncertainty is not None:
            return attempt  # rows hold for all members, the backup law's courses for the model alone
        is_unguarded = attempt.assessment.lowest_psi < UNPROTECTED or self.design.gatekeeper
        return self._choice.guard(attempt) if is_unguarded and attempt.status in ANSWERS else attempt
