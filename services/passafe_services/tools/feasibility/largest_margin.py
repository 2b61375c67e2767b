"""Input with the largest margin to all rows: one linear program for many states.

    max t  subject to  G u ≥ d + t,  u within all limits but the rates,

separately for each state. The programs are independent, so one block-diagonal program solves all of them with one call
of the solver (HiGHS; Huangfu & Hall 2018) instead of thousands. t < 0 is the violation of the rows. A limit on the norm
is approximated by tangents, each added where the previous solution exceeded it (cutting planes, Kelley 1960).
"""

from typing import TYPE_CHECKING, Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.limits import Limits
from passafe.numerics.workspace import Array
from passafe_services.tools.feasibility.batch_rows import StateRows

if TYPE_CHECKING:
    from scipy.sparse import csr_array

NORM_ROUNDS: Final = 40
"""Largest number of tangents per state; an input that is then still too long is led towards the limits' centre."""

TOO_LONG: Final = 1e-7
"""Relative excess of the norm above which another tangent is added."""

LARGEST_COEFFICIENT: Final = 1e15
"""HiGHS treats larger numbers as infinity."""


def largest_margin_inputs(rows: StateRows, limits: Limits) -> tuple[Array, Array]:
    """Return the inputs, shape (C, m), and the margins t that the program claims for them, shape (C,).

    Inputs are within the limits. The margin is −∞ for rows with NaN, +∞ without rows.

    Args:
        rows: One set of rows for each of C states.
        limits: Input limits; rate limits are ignored.
    """
    count, number, m = rows.G.shape
    usable = np.isfinite(rows.G).all(axis=(1, 2)) & np.isfinite(rows.d).all(axis=1)
    u, t = np.zeros((count, m)), np.where(usable, np.inf, -np.inf)
    if number == 0:
        return u, t
    planes = np.array([each.weights for each in limits.half_spaces]).reshape(-1, m)
    cuts, bounds = np.tile(planes, (count, 1, 1)), np.array([each.bound for each in limits.half_spaces])
    left = np.flatnonzero(usable)
    for _ in range(NORM_ROUNDS if limits.norms else 1):
        if not len(left):
            break
        u[left], t[left] = _solve(rows.G[left], rows.d[left], cuts[left], bounds, limits)
        tangents, is_long = _tangents(u, limits)
        left = left[is_long[left]]
        cuts = np.concatenate((cuts, tangents), axis=1)
        bounds = np.append(bounds, [norm.bound for norm in limits.norms])
    return _within(u, limits), t


def _tangents(u: Array, limits: Limits) -> tuple[Array, NDArray[np.bool_]]:
    """Return a tangent of every norm for each state, zero where none is needed, and whether any was."""
    tangents = np.zeros((len(u), len(limits.norms), u.shape[1]))
    is_long = np.zeros(len(u), dtype=np.bool_)
    for place, norm in enumerate(limits.norms):
        axes = list(norm.axes)
        length = np.linalg.norm(u[:, axes], axis=1)
        long = length > norm.bound * (1 + TOO_LONG)
        tangents[np.ix_(long, [place], axes)] = (u[np.ix_(long, axes)] / length[long, None])[:, None]
        is_long |= long
    return tangents, is_long


def _solve(G: Array, d: Array, cuts: Array, bounds: Array, limits: Limits) -> tuple[Array, Array]:
    from scipy.optimize import linprog  # noqa: PLC0415 - a fifth of a second that other commands need not wait

    count, _, m = G.shape
    constraints = np.concatenate((-G, np.ones((*d.shape, 1))), axis=2)
    tangents = np.concatenate((cuts, np.zeros((*cuts.shape[:2], 1))), axis=2)
    blocks = np.concatenate((constraints, tangents), axis=1)
    above = np.concatenate((-d, np.tile(bounds, (count, 1))), axis=1)
    low, high = np.append(limits.low, -LARGEST_COEFFICIENT), np.append(limits.high, LARGEST_COEFFICIENT)
    found = linprog(
        np.tile(np.append(np.zeros(m), -1.0), count),
        A_ub=_block_diagonal(blocks),
        b_ub=above.ravel(),
        bounds=np.tile(np.column_stack((low, high)), (count, 1)),
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9},
    )
    if found.x is None:  # the program is always feasible, as t is unbounded below
        return np.zeros((count, m)), np.full(count, np.inf)
    answer = found.x.reshape(count, m + 1)
    return answer[:, :m], answer[:, m]


def _block_diagonal(blocks: Array) -> "csr_array":
    """Return the block-diagonal matrix of ``blocks``, shape (C, R, k)."""
    from scipy.sparse import bsr_array  # noqa: PLC0415 - likewise

    count, height, k = blocks.shape
    starts = np.arange(count + 1)
    return bsr_array((blocks, starts[:-1], starts), shape=(count * height, count * k)).tocsr()


def _within(u: Array, limits: Limits) -> Array:
    asked = ca.SX.sym("u", u.shape[1])
    centre, low, high = (ca.DM(list(each)) for each in (limits.centre, limits.low, limits.high))
    clip = ca.Function("clip", [asked], [limits.clip(asked, centre, low, high)])
    return np.asarray(clip(u.T).full().T) if len(u) else u
