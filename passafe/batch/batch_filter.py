"""Decisions for many states at once, each with the certificate that ``SafetyPassivityFilter`` asks for.

The filter's own functions are evaluated for the whole batch at once, the answer is guessed in closed form, and the
filter's own certificate judges it. Where it is refused, the scalar filter decides. A strictly convex program has one
answer, so that both lead to the same decision, up to the certificate's tolerance.
"""

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.batch.nearest_points import NearestPoints
from passafe.certificate import accepts
from passafe.decision import Status
from passafe.decision_schema import Answer, Assessment, Evaluation, Program, Request, keeps_barriers
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.fixed_order import product
from passafe.numerics.workspace import Array
from passafe.symbolic.evaluation import UNPROTECTED
from passafe.symbolic.whole_program import limit_bounds, shape_tolerance


class BatchFilter:
    """Decides for every element of a batch; its decisions stay until it decides again.

    Attributes:
        core: The scalar filter.
        batch: Parts of all decisions, a column for each element.
        program: Their programs, shapes (size, count), G (k, C, count).
        evaluation: What follows from their answers, shapes (size, count).
        assessment: Their assessments, shapes (1, count).
        status: Numbers of ``Status``, shape (count,).
        scalar: Whether the scalar filter decided, shape (count,).
    """

    def __init__(self, core: SafetyPassivityFilter, count: int) -> None:
        """Bind the filter's functions.

        Args:
            core: The scalar filter.
            count: Number of elements.

        Raises:
            DesignError: The filter's functions have an operation that arrays do not know.
        """
        self.core = core
        derivation = core.derivation
        self.batch = batch = BatchWorkspace(derivation.layout, count)
        self._prepare = batch.bind(derivation.functions.prepare_usual)
        self._evaluate = batch.bind(derivation.functions.evaluate)
        self.program: Program[Array] = Program.of(batch.view)
        self.evaluation: Evaluation[Array] = Evaluation.of(batch.view)
        self.assessment: Assessment[Array] = Assessment.of(batch.view)
        self._request: Request[Array] = Request.of(batch.view)
        self._answer: Answer[Array] = Answer.of(batch.view)
        self.status: NDArray[np.int8] = np.zeros(batch.count, dtype=np.int8)
        self.scalar: NDArray[np.bool_] = np.zeros(batch.count, dtype=np.bool_)
        uncertainty, n = core.design.uncertainty, core.design.system.n
        given = () if uncertainty is None else uncertainty.state_error or (0.0,) * n
        self._state_error: Array = np.array(given).reshape(-1, 1)
        self._first_axis = 0
        self._points = self._nearest_points()

    @property
    def constraints(self) -> int:
        """Number of rows that are constraints."""
        return self.core.derivation.rows.constraints

    @property
    def hard(self) -> int:
        """Number of hard ones among them; they come first."""
        return self.core.derivation.rows.hard

    @property
    def gradients(self) -> Array:
        """Gradients of the constraints in u, shape (m, C, count)."""
        return self.program.G[: self.core.design.system.m]

    def part(self, name: str) -> Array:
        """Return a part of all decisions, shape (size, count): see ``passafe.decision_schema`` for the names."""
        return self.batch.part(name)

    def decide(
        self,
        x: Array,
        u: Array,
        u_h: Array,
        u_h_rate: Array | float,
        tank_j: Array | float = 0.0,
        t_s: Array | float = 0.0,
        x_error: Array | None = None,
        *,
        start: bool = False,
        scalar: bool = False,
    ) -> None:
        """Decide for every element; the arguments are those of ``SafetyPassivityFilter.decide``, a column for each.

        Args:
            x: States, shape (n, elements).
            u: Inputs in force, shape (m, elements).
            u_h: Operators' parts, shape (m, elements).
            u_h_rate: Their time derivatives, shape (m, elements).
            tank_j: Energies in the tanks, J, shape (elements,).
            t_s: Plant times, s, shape (elements,).
            x_error: Largest errors of the states, shape (n, elements) or (n, 1); the design's if not given.
            start: Whether there was no input before; then the scalar filter decides.
            scalar: Whether the scalar filter shall decide for every element.
        """
        request, used = self._request, slice(self.batch.used)
        request.x[:, used], request.u[:, used] = x, u
        request.u_h[:, used], request.u_h_rate[:, used] = u_h, u_h_rate
        request.tank[:, used], request.t[:, used] = tank_j, t_s
        request.x_error[:, used] = self._state_error if x_error is None else x_error
        if start or scalar or self.core.design.gatekeeper:
            self.scalar[:] = True
        else:
            with np.errstate(all="ignore"):  # a NaN fails the certificate
                self._decide_batch()
        for element in np.flatnonzero(self.scalar[used]).tolist():
            self._decide_scalar(element, start=start)

    def _decide_batch(self) -> None:
        self._request.start.fill(0.0)
        self._prepare()
        self._guess()
        self._evaluate()
        self._grade()

    def _nearest_points(self) -> NearestPoints:
        """Return what guesses answers, with the rows of the limits."""
        rows, m = self.core.derivation.rows, self.core.design.system.m
        # Tangents of a norm are the same before one is needed, so one is enough; those of further norms are left out,
        # and the scalar filter decides where they bind.
        limits = self.core.design.limits
        weights, asked, lengths = (part.full() for part in limit_bounds(limits))
        self._weights, self._asked, self._lengths = weights, asked, lengths[:1]
        planes = len(weights)
        points = NearestPoints(rows.columns, rows.constraints + 2 * m + planes + len(self._lengths), self.batch.count)
        axes, first = np.eye(rows.columns, m)[:, :, None], rows.constraints
        points.rows[:, first : first + m] = axes
        points.rows[:, first + m : first + 2 * m] = -axes
        points.rows[:m, first + 2 * m : first + 2 * m + planes] = -weights.T[:, :, None]
        for norm in limits.norms[:1]:
            points.rows[norm.axes[0], first + 2 * m + planes :] = -1.0
            self._first_axis = norm.axes[0]
        return points

    def _guess(self) -> None:
        """Put the guess of the whole program's answer, limits included, where the answer belongs."""
        points, program, answer = self._points, self.program, self._answer
        bounds, u_ref = points.bounds, program.u_ref
        first, m = len(program.d), len(u_ref)
        points.rows[:, :first] = program.G
        bounds[:first] = program.d
        np.subtract(program.low, u_ref, bounds[first : first + m])
        np.subtract(u_ref, program.high, bounds[first + m : first + 2 * m])
        tangent = first + 2 * m + len(self._asked)
        if len(self._asked):
            np.subtract(product(self._weights, u_ref), self._asked, bounds[first + 2 * m : tangent])
        np.subtract(u_ref[self._first_axis : self._first_axis + len(self._lengths)], self._lengths, bounds[tangent:])
        points.find(answer.z, answer.lam[: len(bounds)])

    def _grade(self) -> None:
        """Leave what the filter would not accept to the scalar filter, and grade the rest as it does."""
        design, assessment = self.core.design, self.assessment
        is_short_enough = assessment.norm_overreach <= shape_tolerance(design.limits)
        settled = keeps_barriers(assessment) & (assessment.extra_slack <= design.passivity.relaxed_above)
        is_judged = self.core.compares_courses & (assessment.lowest_psi < UNPROTECTED)
        is_untouched = ~self._answer.lam.any(axis=0)
        is_wasteful = (assessment.waste > 0.0) & ~is_untouched
        is_doubtful = ~(accepts(design.tolerance, assessment) & is_short_enough & settled)
        self.scalar[:] = (is_doubtful | is_judged | is_wasteful)[0]
        modified = np.where(assessment.slack[0] > design.passivity.relaxed_above, Status.RELAXED, Status.MODIFIED)
        self.status[:] = np.where(is_untouched, Status.PASSED, modified)

    def _decide_scalar(self, element: int, *, start: bool) -> None:
        request = self._request
        x, u, u_h, u_h_rate = (
            part[:, element].tolist() for part in (request.x, request.u, request.u_h, request.u_h_rate)
        )
        tank_j, t_s = float(request.tank[0, element]), float(request.t[0, element])
        x_error = request.x_error[:, element].tolist() or None
        decision = self.core.decide(x, u, u_h, u_h_rate, tank_j, t_s, start=start, x_error=x_error)
        self.batch.block[:, element] = decision.block
        self.status[element] = decision.status
