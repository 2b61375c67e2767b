"""Input with the largest margin to all rows: one linear program for many states.

    max t  subject to  G u ≥ d + t,  u within magnitude and norm limits,

separately for each state. The programs are independent, so one block-diagonal program solves all of them with one call
of the solver (HiGHS; Huangfu & Hall 2018) instead of thousands. t < 0 is the violation of the rows. A limit on the norm
is approximated by tangents, each added where the previous solution exceeded it (cutting planes, Kelley 1960).
"""

from typing import Final

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import bsr_array

from passafe.limits import Limits
from passafe.workspace import Array
from passafe_services.tools.feasibility.batch_rows import StateRows

NORM_ROUNDS: Final = 40
"""Largest number of tangents per state; an input that is then still too long is scaled."""

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
    cuts = np.zeros((count, 0, m))
    left = np.flatnonzero(usable)
    for _ in range(NORM_ROUNDS if limits.norm is not None else 1):
        if not len(left):
            break
        u[left], t[left] = _solve(rows.G[left], rows.d[left], cuts[left], limits)
        if limits.norm is None:
            break
        length = np.linalg.norm(u, axis=1)
        left = left[length[left] > limits.norm * (1 + TOO_LONG)]
        tangents = np.zeros((count, 1, m))
        tangents[left, 0] = u[left] / length[left, None]
        cuts = np.concatenate((cuts, tangents), axis=1)
    return _within(u, limits), t


def _solve(G: Array, d: Array, cuts: Array, limits: Limits) -> tuple[Array, Array]:
    count, _, m = G.shape
    constraints = np.concatenate((-G, np.ones((*d.shape, 1))), axis=2)
    tangents = np.concatenate((cuts, np.zeros((*cuts.shape[:2], 1))), axis=2)
    blocks = np.concatenate((constraints, tangents), axis=1)
    above = np.concatenate((-d, np.full(cuts.shape[:2], limits.norm or 0.0)), axis=1)
    magnitude = np.array(limits.magnitude)
    low, high = np.append(-magnitude, -LARGEST_COEFFICIENT), np.append(magnitude, LARGEST_COEFFICIENT)
    found = linprog(
        np.tile(np.append(np.zeros(m), -1.0), count),
        A_ub=_block_diagonal(blocks).tocsr(),
        b_ub=above.ravel(),
        bounds=np.tile(np.column_stack((low, high)), (count, 1)),
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9},
    )
    if found.x is None:  # the program is always feasible, as t is unbounded below
        return np.zeros((count, m)), np.full(count, np.inf)
    answer = found.x.reshape(count, m + 1)
    return answer[:, :m], answer[:, m]


def _block_diagonal(blocks: Array) -> bsr_array:
    """Return the block-diagonal matrix of ``blocks``, shape (C, R, k)."""
    count, height, k = blocks.shape
    starts = np.arange(count + 1)
    return bsr_array((blocks, starts[:-1], starts), shape=(count * height, count * k))


def _within(u: Array, limits: Limits) -> Array:
    clipped: Array = np.clip(u, -np.array(limits.magnitude), np.array(limits.magnitude))
    if limits.norm is None:
        return clipped
    length = np.linalg.norm(clipped, axis=1, keepdims=True)
    shortened: Array = clipped * (limits.norm / np.maximum(length, limits.norm))
    return shortened
