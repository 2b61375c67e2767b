"""The override of one decision: the change of the request, its causes, and the part that would have passed.

Asked for is u_want = u + dt·φ, or û where there was no input before. The decision is

    u⁺ − u_want = Σᵢ λᵢ gᵢ,

the multipliers' stationarity: every row that binds pushes by λᵢ along its gradient of unit length, and a limit of an
axis pushes by what it cuts off u_want, too. u_want moves with the operator's part by k = dt·k_i (1 at the start), so
(u⁺ − u_want)/k is by how much the command would have had to differ for the same input to pass without any change.
"""

from dataclasses import dataclass
from math import inf
from typing import Final

import casadi as ca
import numpy as np

from passafe.decision import Decision, Status
from passafe.decision_schema import Answer, Evaluation, NormTangents, Program, Request
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.fixed_order import length
from passafe.numerics.stage import Stage, T
from passafe.numerics.workspace import Array, BlockLayout, Workspace, expressions_by_name, named_function
from passafe.symbolic.whole_program import limit_bounds

ACTIVE_DUAL: Final = 1e-6
"""Push from which a row counts as active, units of u."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OverrideCause:
    """A row that pushed.

    Attributes:
        row: Its name.
        push: λ, units of u; for a limit of an axis with what it cut off what was asked for.
        share: Share of the change, λ gᵀ(u⁺ − u_want)/‖u⁺ − u_want‖². The shares of all rows sum to 1; one is negative
            where the others push against it.
    """

    row: str
    push: float
    share: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Override:
    """The change of a request by the filter.

    Attributes:
        change: u⁺ − u_want, shape (m,), units of u.
        held_back: The same in terms of the operator's command, (u⁺ − u_want)/k, shape (m,), units of u. Where the
            input has settled it is u⁺ − û.
        causes: Active rows, the one with the largest share first; none under the fail-safe law.
        allowed_fraction: Largest s in [0, 1] for which the command s·(u_h, u̇_h) would have passed without a change: no
            row relaxed, no slack, no limit in the way. 0 where no s would have.
        unavoidable: True if no s in [0, 1] would have.
    """

    change: Array
    held_back: Array
    causes: tuple[OverrideCause, ...]
    allowed_fraction: float
    unavoidable: bool

    @property
    def size(self) -> float:
        """‖held_back‖, units of u."""
        return length(self.held_back)


class Explainer:
    """Explains the decisions of one filter.

    Rows count as they are in the decision: with its tangents, where they are not affine in u, and with its margins
    between samples, which are made for inputs near u⁺. They are kept where they are missed by no more than the
    certificate tolerates.

    What it computes is one CasADi function: dozens of calls for a few numbers each would take longer than the decision.
    """

    def __init__(self, core: SafetyPassivityFilter) -> None:
        """Derive and compile the explanation of a filter's decisions."""
        self._names = core.row_names
        shapes = core.layout.shapes

        def symbol(name: str) -> ca.SX:
            return ca.SX.sym(name, *shapes[name])

        request, program, answer = Request.of(symbol), Program.of(symbol), Answer.of(symbol)
        tangents, evaluation = NormTangents.of(symbol), Evaluation.of(symbol)
        explanation = _explain(core, request, program, tangents, answer, evaluation)
        read = expressions_by_name(request, program, tangents, answer, evaluation)
        function = named_function("explain", read, explanation.fields())
        sizes = {name: expression.numel() for name, expression in explanation.fields().items()}
        self._space = space = Workspace(BlockLayout.of({**shapes, **sizes}))
        self._evaluate = space.bind(function)
        self._decided = space.block[: core.layout.size]
        self._explanation = Explanation.of(space.view)
        self._read_push, self._read_share = space.reader("push"), space.reader("share")

    def override(self, decision: Decision) -> Override:
        """Return the override of a decision."""
        self._decided[:] = decision.block
        self._evaluate()
        explanation = self._explanation
        change, fraction = explanation.change.copy(), float(explanation.allowed_fraction[0])
        if decision.status is Status.PASSED and not change.any():
            return Override(change=change, held_back=change, causes=(), allowed_fraction=1.0, unavoidable=False)
        return Override(
            change=change,
            held_back=explanation.held_back.copy(),
            causes=self._causes(),
            allowed_fraction=max(fraction, 0.0),
            unavoidable=fraction < 0.0,
        )

    def explain(self, blocks: Array) -> "Explanation[Array]":
        """Return the numbers behind the overrides of many decisions.

        Args:
            blocks: Blocks of the decisions, shape (N, numbers of a decision).
        """
        space, decided, evaluate = self._space, self._decided, self._evaluate
        explained = space.block[decided.size :]
        found = np.empty((len(blocks), explained.size))
        for block, row in zip(blocks, found, strict=True):
            decided[:] = block
            evaluate()
            row[:] = explained
        parts = space.layout.parts
        return Explanation.of(lambda name: found[:, parts[name].start - decided.size : parts[name].stop - decided.size])

    def _causes(self) -> tuple[OverrideCause, ...]:
        """Return the active rows in the order of their shares."""
        rows = zip(self._names, self._read_push(), self._read_share(), strict=True)
        causes = [OverrideCause(row=name, push=push, share=share) for name, push, share in rows if push > ACTIVE_DUAL]
        return tuple(sorted(causes, key=lambda cause: -cause.share))


class Explanation(Stage[T], frozen=True, eq=False, gc=False):
    """Expressions or values of one decision, or values of many: N rows.

    Attributes:
        change: u⁺ − u_want, m.
        held_back: The same in terms of the operator's command, m.
        push: λ of every row, N, see ``OverrideCause.push``.
        share: Its share of the change, N.
        allowed_fraction: Part of the command that would have passed, 1; −1 where there is none.
    """

    change: T
    held_back: T
    push: T
    share: T
    allowed_fraction: T


def _explain(
    core: SafetyPassivityFilter,
    request: Request[ca.SX],
    program: Program[ca.SX],
    tangents: NormTangents[ca.SX],
    answer: Answer[ca.SX],
    evaluation: Evaluation[ca.SX],
) -> Explanation[ca.SX]:
    design = core.design
    m, dt_s = design.system.m, design.dt_s
    start, u_h = request.start, request.u_h
    wanted = ca.if_else(start, program.u_nominal, request.u + dt_s * program.phi)
    gain = ca.if_else(start, 1.0, dt_s * design.k_i)
    command = ca.if_else(start, u_h, gain * u_h + dt_s * request.u_h_rate)
    change = evaluation.u_plus - wanted
    G, cuts = program.G[:, :m], tangents.cuts
    cut_off = program.u_ref - wanted
    axes = ca.fmax(ca.vertcat(cut_off, -cut_off), 0)
    planes = ca.SX(limit_bounds(design.limits)[0])
    bounds = ca.DM([half_space.bound for half_space in design.limits.half_spaces])
    push = answer.lam + ca.vertcat(ca.SX(core.constraints, 1), axes, ca.SX(planes.shape[0] + cuts.shape[0], 1))
    along = ca.vertcat(G @ change, change, -change, -planes @ change, -cuts @ change)
    square = ca.sumsqr(change)
    in_axes = ca.vertcat(wanted - program.low, program.high - wanted)
    kept = ca.vertcat(G @ (wanted - program.u_ref) - program.d, in_axes, bounds - planes @ wanted)
    slopes = ca.vertcat(G @ command, command, -command, -planes @ command)
    least, most = _interval(kept + design.tolerance.residual, slopes)
    for norm in design.limits.norms:
        length = norm.bound + design.tolerance.residual
        at_least, at_most = _within(wanted[list(norm.axes)], command[list(norm.axes)], length)
        least, most = ca.fmax(least, at_least), ca.fmin(most, at_most)
    is_number = ca.sumsqr(wanted) + ca.sumsqr(command) < inf
    return Explanation(
        change=change,
        held_back=change / gain,
        push=push,
        share=ca.if_else(square > 0, push * along / square, 0),
        allowed_fraction=ca.if_else(ca.logic_and(is_number, least <= ca.fmin(most, 1)), 1 - least, -1),
    )


def _interval(kept: ca.SX, slope: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the least and the largest q ≥ 0 with kept − q·slope ≥ 0 in every place; the least is inf without one."""
    ends = kept / slope
    rises = ca.logic_and(kept < 0, slope < 0)
    never = ca.logic_not(ca.logic_or(slope > 0, ca.logic_or(rises, kept >= 0)))
    least = ca.if_else(never, inf, ca.if_else(rises, ends, 0))
    return ca.mmax(ca.vertcat(0, least)), ca.mmin(ca.vertcat(inf, ca.if_else(slope > 0, ends, inf)))


def _within(wanted: ca.SX, command: ca.SX, norm: float) -> tuple[ca.SX, ca.SX]:
    """Return the least and the largest q with ‖wanted − q·command‖ ≤ norm; inf and −inf without one."""
    a, b, c = ca.sumsqr(command), ca.dot(command, wanted), ca.sumsqr(wanted) - norm**2
    under = b * b - a * c
    root = ca.sqrt(ca.fmax(under, 0))
    some, always = ca.logic_and(a > 0, under >= 0), ca.logic_and(a == 0, c <= 0)
    return (
        ca.if_else(always, -inf, ca.if_else(some, (b - root) / a, inf)),
        ca.if_else(always, inf, ca.if_else(some, (b + root) / a, -inf)),
    )
