"""The proof that hard rows contradict one another within the limits (Farkas' lemma)."""

import casadi as ca

from passafe.decision_schema import Program
from passafe.limits import Limits


def conflict(limits: Limits, program: Program[ca.SX], weights: ca.SX) -> ca.SX:
    """Return the demand of weighted hard rows beyond what any input gives, scalar; positive proves the conflict.

    Σμᵢdᵢ − max (Σμᵢgᵢ)ᵀw over all w = u⁺ − u_ref within the limits, which has a closed form.

    Args:
        limits: The filter's.
        program: Symbols.
        weights: μ ≥ 0 of the H hard rows, shape (H, 1).
    """
    hard, m = weights.numel(), program.u_ref.numel()
    pull = ca.sum1(program.G[:hard, :m] * ca.repmat(weights, 1, m)).T
    most = ca.sum1(ca.fmax(pull * (program.low - program.u_ref), pull * (program.high - program.u_ref)))
    if limits.norm is not None:
        most = ca.fmin(most, limits.norm * ca.norm_2(pull) - ca.dot(pull, program.u_ref))
    asked = ca.sum1(weights * program.d[:hard]) if hard else ca.SX(0)
    return asked - most
