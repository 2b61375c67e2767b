"""The schema of a decision: the stages from a request to a certified answer, and the parts of each.

Everything else follows from these declarations and from the shapes of a design's expressions: the arguments and results
of the compiled functions, the places of the parts in a decision's block, and every view of them.

Sizes: n states, m inputs, N rows of the whole program, C of them constraints, H of these hard; k = m, or m + 1 with a
soft row. Inputs are in units of u.
"""

from typing import overload

import numpy as np
from numpy.typing import NDArray

from passafe.certificate import Residuals
from passafe.numerics.stage import Matrix, Stage, T
from passafe.numerics.workspace import Array


class Request(Stage[T], frozen=True, eq=False, gc=False):
    """Arguments of a decision.

    Attributes:
        x: State at which the input takes effect, n.
        u: Input in force until then, m.
        u_h: Operator's part of the input, m.
        u_h_rate: Its time derivative, m, per second.
        tank: Energy E in the tank, J, 1.
        t: Plant time at which the input takes effect, s, 1.
        start: 1 where there was no input before, else 0.
        x_error: Largest error of each state, n; none where rows hold for the model alone.
    """

    x: T
    u: T
    u_h: T
    u_h_rate: T
    tank: T
    t: T
    start: T
    x_error: T


class Linearization(Stage[T], frozen=True, eq=False, gc=False):
    """Input about which rows that are not affine in u are linearized, and the region in which their margins are valid.

    Attributes:
        u_lin: Input at which tangents touch, centre of the trust region, m.
        trust_asked: Radius of the trust region that is asked for, m; 0 to have it reach u_ref.
        tightening: Distance beyond ε by which constraints are kept, 1.
        with_margins: 1 to keep rows with their margins between samples, 0 to leave these out, 1.
        with_sets: 1 to keep rows for all members of a family of plants, 0 for those in the middle and at the ends
            alone, 1; empty without a family.
    """

    u_lin: T
    trust_asked: T
    tightening: T
    with_margins: T
    with_sets: T


class ReferenceInput(Stage[T], frozen=True, eq=False, gc=False):
    """The input that the filter would send if no row stood in the way.

    Attributes:
        u_nominal: û = u_fb(x) + u_h, m.
        phi: Tracking term φ, m, per second.
        u_ref: u + dt·φ, or û at the start, clipped to ``low`` and ``high``, m: where z = 0.
        low: Least input that magnitude and rate allow, m.
        high: Largest one, m.
    """

    u_nominal: T
    phi: T
    u_ref: T
    low: T
    high: T


class Program(ReferenceInput[T], frozen=True, eq=False, gc=False):
    """The quadratic program min ½‖z‖² subject to G z ≥ d, and what it was made from.

    The reference input comes first.

    Attributes:
        trust: Radius of the trust region in which margins are valid, m.
        deviation: Bound of what is unknown of every enforced barrier over a period, in the units of ψ_r.
        power_deviation: The same of the power margin, W, 1; 0 where passivity is not enforced.
        uncertainty: What members of a family of plants take of every enforced barrier, in the units of ψ_r; none for
            the model alone.
        power_uncertainty: The same of the power margin, W; none likewise, or where passivity is not enforced.
        unbounded: Number of these that are not known, 1.
        G: Rows of the constraints, of unit length, shape (C, k).
        d: Their bounds, C.
        largest_bound: max d, 1; where it is not positive, z = 0 is optimal.
        nan_guard: 0 for ordinary numbers, NaN or infinite where an argument or a row is, 1.
    """

    trust: T
    deviation: T
    power_deviation: T
    uncertainty: T
    power_uncertainty: T
    unbounded: T
    G: Matrix[T]
    d: T
    largest_bound: T
    nan_guard: T


class NormTangents(Stage[T], frozen=True, eq=False, gc=False):
    """Linear rows in the place of the limits of the norms.

    Attributes:
        cuts: Directions of unit length, one a row, shape (tangents, m); none without such limits.
    """

    cuts: Matrix[T]


class Answer(Stage[T], frozen=True, eq=False, gc=False):
    """An answer to the quadratic program; all zero before a solver is asked.

    Attributes:
        z: u⁺ − u_ref and, with a soft row, its slack times √ρ, k.
        lam: Multipliers λ of all rows, N.
        relax: Relaxation of hard rows that conflict, H.
        limit_weights: Weights of half-spaces and tangents beside ``relax`` in the proof of the conflict.
        conflict: 1; positive where ``relax`` proves that the hard rows cannot be kept within the limits.
    """

    z: T
    lam: T
    relax: T
    limit_weights: T
    conflict: T


class Evaluation(Stage[T], frozen=True, eq=False, gc=False):
    """Consequences of an answer.

    Attributes:
        margins: G z − d of all rows, limits included, N.
        u_plus: u⁺, m.
        v: (u⁺ − u)/dt − φ, m, per second.
        psi: ψ₀ … ψ_r of every barrier at (x, u⁺), one barrier after the other.
        eps: Margin ε of every enforced barrier between samples under u⁺, in the units of ψ_r, and what members of a
            family of plants take.
        h_u: Power margin at (x, u⁺), W, 1.
    """

    margins: T
    u_plus: T
    v: T
    psi: T
    eps: T
    h_u: T


class Assessment(Residuals[T], frozen=True, eq=False, gc=False):
    """The numbers by which an answer is accepted and graded, each a scalar.

    Residuals come first.

    Attributes:
        norm_overreach: Length beyond the one asked for, of a norm or across a half-space; 0 without such limits.
        slack: δ with which u⁺ keeps the passivity row for the whole period, W; 0 where there is none.
        extra_slack: Part of it that the program did not count, W.
        shortfall: Distance by which u⁺ violates a barrier's row with its margin; ≤ 0 if it keeps all.
        outside_trust_region: Distance of u⁺ from the trust region; ≤ 0 inside.
        unknown_margins: Number of margins that the answer would need and that are not known.
        lowest_psi: Smallest of ψ₀ … ψ_{r−1} of all enforced barriers; below 0 nothing is proven of h.
        waste: How far from u⁺ what is unknown of margins, in all of the trust region, may keep better answers, beyond
            what is spared; ≤ 0 where that is little.
        concern: Largest of what may stand in the way of an accepted answer: of the five before beyond what is allowed,
            and of the slack beyond what counts as relaxed; ≤ 0 where nothing does.
    """

    norm_overreach: T
    slack: T
    extra_slack: T
    shortfall: T
    outside_trust_region: T
    unknown_margins: T
    lowest_psi: T
    waste: T
    concern: T


@overload
def keeps_barriers(assessment: Assessment[float]) -> bool: ...
@overload
def keeps_barriers(assessment: Assessment[Array]) -> NDArray[np.bool_]: ...
def keeps_barriers(assessment: Assessment[float] | Assessment[Array]) -> bool | np.bool_ | NDArray[np.bool_]:
    """Return whether margins and tangents of the hard rows suit the answer that was found with them.

    Args:
        assessment: Of one answer, or of every element of a batch.
    """
    return (
        (assessment.shortfall <= 0.0) & (assessment.outside_trust_region <= 0.0) & (assessment.unknown_margins <= 0.0)
    )
