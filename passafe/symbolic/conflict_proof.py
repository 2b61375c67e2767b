"""The proof that hard rows contradict one another within the limits (Farkas' lemma)."""

import casadi as ca

from passafe.decision_schema import Answer, NormTangents, Program
from passafe.limits import Limits
from passafe.symbolic.whole_program import limit_bounds, tangents_of


def conflict(limits: Limits, program: Program[ca.SX], tangents: NormTangents[ca.SX], answer: Answer[ca.SX]) -> ca.SX:
    """Return the demand of weighted hard rows beyond what any input gives, scalar; positive proves the conflict.

    Σμᵢdᵢ − max (Σμᵢgᵢ)ᵀw over all w = u⁺ − u_ref within the limits, for μ = ``relax``; for the maximum stands the
    smaller of two upper bounds: ``most_along`` of the pull itself, and with half-spaces and tangents of the norms,
    each weighted by what it held against the pull.

    Args:
        limits: The filter's.
        program: Symbols.
        tangents: Symbols.
        answer: Symbols; only the weights μ ≥ 0 and ν ≥ 0 count.
    """
    hard, m = answer.relax.numel(), program.u_ref.numel()
    pull = ca.sum1(program.G[:hard, :m] * ca.repmat(answer.relax, 1, m)).T
    most = most_along(limits, program, pull)
    if not limits.has_only_axes:
        most = ca.fmin(most, _with_limits(limits, program, pull, tangents.cuts, answer.limit_weights))
    asked = ca.sum1(answer.relax * program.d[:hard]) if hard else ca.SX(0)
    return asked - most


def most_along(limits: Limits, program: Program[ca.SX], pull: ca.SX) -> ca.SX:
    """Return an upper bound of pullᵀw over all inputs within axes, rates and norms, scalar.

    Each axis counts in the first norm that it belongs to; over its axes the smaller of the interval's maximum and the
    ball's stands, B‖pull‖ − pullᵀu_ref. Exact without norms.

    Args:
        limits: The filter's.
        program: Symbols.
        pull: Shape (m, 1).
    """
    over_axes = ca.fmax(pull * (program.low - program.u_ref), pull * (program.high - program.u_ref))
    most, left = ca.SX(0), list(range(len(limits.low)))
    for norm in limits.norms:
        axes = [axis for axis in left if axis in norm.axes]
        left = [axis for axis in left if axis not in axes]
        if axes:
            in_ball = norm.bound * ca.norm_2(pull[axes]) - ca.dot(pull[axes], program.u_ref[axes])
            most += ca.fmin(ca.sum1(over_axes[axes]), in_ball)
    return most + (ca.sum1(over_axes[left]) if left else ca.SX(0))


def _with_limits(limits: Limits, program: Program[ca.SX], pull: ca.SX, cuts: ca.SX, weights: ca.SX) -> ca.SX:
    """Return the bound by weak duality: what is left of the pull, over the axes, and ν times each limit's bound.

    Every tangent is a half-space cutsᵀu ≤ B that contains the ball, wherever it touches.
    """
    normals = ca.vertcat(ca.SX(limit_bounds(limits)[0]), cuts)
    bounds = [each.bound for each in limits.half_spaces]
    bounds += [norm.bound for norm in limits.norms for _ in range(tangents_of(norm))]
    room = ca.DM(bounds) - normals @ program.u_ref
    return most_along(limits, program, pull - normals.T @ weights) + ca.dot(weights, room)
