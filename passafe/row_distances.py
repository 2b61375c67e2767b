"""Distances to infeasibility of many decisions at once, to the last bit those of ``DistanceToInfeasibility``.

Most decisions are settled by one row, and those together, by the same operations in the same order. The others are left
to it: where half-spaces bound the input or a norm is near, where numbers are not finite, where one row does not decide.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.infeasibility import CLOSED
from passafe.limits import Limits
from passafe.workspace import Array, BlockLayout

CLEAR: Final = 1e-6
"""Distance from a norm, relative to its square, at which it is surely not touched."""


class RowDistances:
    """Distances that one row decides.

    Args:
        limits: The filter's.
        hard: Number of hard rows.
        layout: Places of the parts in a decision's block.
    """

    def __init__(self, limits: Limits, hard: int, layout: BlockLayout) -> None:
        self._limits, self._hard, self._layout, self._m = limits, hard, layout, len(limits.low)

    def of(self, blocks: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return lower bounds of the distances of N decisions, and which of them are decided.

        Args:
            blocks: Blocks of the decisions, shape (N, numbers of a decision).
        """
        reach = self._limits.reach
        if not self._hard:
            return np.full(len(blocks), reach), np.ones(len(blocks), dtype=np.bool_)
        if self._limits.half_spaces:
            return np.zeros(len(blocks)), np.zeros(len(blocks), dtype=np.bool_)
        parts = self._layout.parts
        u_ref, d = blocks[:, parts["u_ref"]], blocks[:, parts["d"]][:, : self._hard]
        G = self._rows(blocks)
        low, high = blocks[:, parts["low"]] - u_ref, blocks[:, parts["high"]] - u_ref
        known = blocks[:, parts["u_plus"]] - u_ref
        corners = np.where(G > 0.0, high[:, None], low[:, None])
        most = _sum(G * corners) - d
        rows = most.argmin(axis=1)[:, None]
        corner = np.take_along_axis(corners, rows[..., None], axis=1)[:, 0]
        corner = np.minimum(np.maximum(corner, low), high)
        answer, best = _kept(G, known, d), _kept(G, corner, d)
        lower = np.where(best > answer, best, answer)
        upper = np.minimum(reach, np.take_along_axis(most, rows, axis=1)[:, 0])
        decided = self._is_clear_of_norms(u_ref + known, corner - known) & (upper - lower <= CLOSED * reach)
        decided |= answer >= reach
        decided &= np.isfinite(most).all(axis=1) & np.isfinite(answer)
        return np.where(answer >= reach, reach, np.minimum(lower, reach)), decided

    def _rows(self, blocks: Array) -> Array:
        """Return the hard rows, shape (N, hard, m), each as a decision holds them: column by column."""
        count, size = self._layout.shapes["G"]
        rows = blocks[:, self._layout.parts["G"]].reshape(len(blocks), size, count)
        return rows.transpose(0, 2, 1)[:, : self._hard, : self._m]

    def _is_clear_of_norms(self, start: Array, step: Array) -> NDArray[np.bool_]:
        """Return where no norm ends the way from an input to another."""
        clear = np.ones(len(start), dtype=np.bool_)
        for norm in self._limits.norms:
            ends = start[:, list(norm.axes)] + step[:, list(norm.axes)]
            clear &= (ends * ends).sum(axis=1) < norm.bound**2 * (1.0 - CLEAR)
        return clear


def _kept(G: Array, w: Array, d: Array) -> Array:
    """Return by how much each w keeps the row that it keeps least."""
    kept: Array = (np.einsum("nij,nj->ni", G, w) - d).min(axis=1)  # of each as in passafe.fixed_order
    return kept


def _sum(products: Array) -> Array:
    """Return the sums over the last axis, from the first on."""
    total: Array = products[..., 0]
    for k in range(1, products.shape[-1]):
        total = total + products[..., k]
    return total
