"""The search of all admissible inputs for one that keeps hard rows which are not affine in u.

Branch and bound over the box of the axes' limits (Moore, Kearfott & Cloud 2009, chapter 6): a box in which some row is
below zero for every input is left out, and where none is left, no admissible input keeps the rows. The centre of every
box is tried. The number of boxes is bounded; where it runs out, nothing is found and nothing is proven.
"""

from dataclasses import dataclass
from heapq import heappop, heappush
from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.enclosures.enclosure import enclose
from passafe.numerics.fixed_order import length
from passafe.numerics.workspace import Array, dense_function
from passafe.program.decision_block import DecisionBlock
from passafe.symbolic.enforced_barriers import EnforcedBarriers

BOXES: Final = 2000
"""Boxes that are looked at, at most, for an input that keeps the rows."""

DEEPEST_BOXES: Final = 200
"""Boxes that are looked at for the input that keeps them best."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Found:
    """Outcome of a search.

    Attributes:
        u: An admissible input that keeps every hard row, shape (m,); ``None`` where none was found.
        is_impossible: Whether no admissible input does, proven.
    """

    u: Array | None = None
    is_impossible: bool = False


class InputSearch:
    """Searches the inputs of one design."""

    def __init__(self, barriers: EnforcedBarriers) -> None:
        """Derive the rows' enclosure over boxes of inputs.

        Args:
            barriers: The enforced ones.
        """
        system, self._limits = barriers.design.system, barriers.design.limits
        rows = ca.vertcat(ca.SX(0, 1), *(held.value for held in barriers.held))
        radius = ca.SX.sym("radius", system.m)
        ball = enclose(rows, system.u, radius)
        most = ca.if_else(ball.known, ca.mmin(ball.centre + ball.radius), np.inf)
        self._look = dense_function("look", [system.x, system.t, system.u, radius], [ca.mmin(rows), most])

    def find(self, block: DecisionBlock) -> Found:
        """Return what is found for the request of a block, within the limits of its program.

        Args:
            block: Holds request and program.
        """
        best = self._best(block, enough=0.0, boxes=BOXES)
        if best.kept >= 0.0:
            return Found(u=best.u)
        return Found(is_impossible=best.is_last)

    def deepest(self, block: DecisionBlock) -> Array:
        """Return the admissible input that was found to keep the row best that it keeps least, shape (m,).

        Rows without margins that an input just keeps leave no room for margins; others may.

        Args:
            block: Holds request and program.
        """
        return self._best(block, enough=np.inf, boxes=DEEPEST_BOXES).u

    def _best(self, block: DecisionBlock, *, enough: float, boxes: int) -> "_Best":
        """Return the best of the centres of at most so many boxes, the first that is good enough."""
        request, program = block.request, block.program
        limits = (request.u.copy(), program.low.copy(), program.high.copy())
        queue: list[tuple[float, int, Array, Array]] = []
        heappush(queue, (-np.inf, 0, limits[1], limits[2]))
        best, kept_best = limits[0], -np.inf
        for looked_at in range(1, boxes + 1):
            if not queue:
                return _Best(best, kept_best, is_last=True)
            _, _, low, high = heappop(queue)
            centre = (low + high) / 2
            tried = self._limits.nearest(centre, *limits)
            kept = float(self._look(request.x, request.t, tried, np.zeros(len(low)))[0])
            if kept > kept_best:
                best, kept_best = tried, kept
            if kept_best >= enough:
                break
            axis = int((high - low).argmax())
            for half in range(2):
                part_low, part_high = low.copy(), high.copy()
                (part_high if half == 0 else part_low)[axis] = centre[axis]
                bound = self._bound(request.x, request.t, part_low, part_high)
                if bound >= max(kept_best, 0.0):
                    heappush(queue, (-bound, 2 * looked_at + half, part_low, part_high))
        return _Best(best, kept_best, is_last=False)

    def _bound(self, x: Array, t: Array, low: Array, high: Array) -> float:
        """Return the most that the row kept least can be kept by in a box; below zero where none is admissible."""
        if self._is_beyond(low, high):
            return -np.inf
        return float(self._look(x, t, (low + high) / 2, (high - low) / 2)[1])

    def _is_beyond(self, low: Array, high: Array) -> bool:
        """Return whether no input of a box is within the limits of norms and half-spaces."""
        least = np.maximum(np.maximum(low, -high), 0.0)
        too_long = any(length(least[list(norm.axes)]) > norm.bound for norm in self._limits.norms)
        return too_long or any(
            np.minimum(low * half.weights, high * half.weights).sum() > half.bound for half in self._limits.half_spaces
        )


class _Best(NamedTuple):
    """The best input of a search, by how much it keeps the row that it keeps least, and whether no box is left."""

    u: Array
    kept: float
    is_last: bool
