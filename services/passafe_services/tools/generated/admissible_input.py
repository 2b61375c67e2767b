"""The oracle: whether some input within the limits keeps all rows in a state, found without the filter.

With rows affine in u and at most two axes the inputs that keep them are a polygon, whose shortest member is zero, the
foot of a perpendicular on one edge, or a corner: an exact answer, for as many states at once as are given. Rows that
are not affine are tried on a grid of the inputs within the limits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array
from passafe.system import System
from passafe_services.tools.generated.protected_set import RandomChain

KEPT: Final = 1e-9
"""By how much a row of unit length may be missed, relative to 1 + its bound."""

PARALLEL: Final = 1e-9
"""Sine of the angle below which two edges have no corner."""

PLANE: Final = 2
"""Number of axes for which there are corners."""

HOPELESS: Final = 1e30
"""Bound of a row that no input keeps."""

GRID: Final = {1: 2001, 2: 41}
"""Values of each axis, by the number of axes."""


@dataclass(frozen=True, kw_only=True, slots=True)
class InputLimits:
    """Limits as they were drawn: whatever the filter made of them, its inputs are compared with these.

    Attributes:
        magnitude: Of each axis.
        norm: Largest norm; ``None`` for none.
        rate_per_s: Of each axis, per second; ``None`` for none.
    """

    magnitude: tuple[float, ...]
    norm: float | None = None
    rate_per_s: tuple[float, ...] | None = None

    def overreach(self, u: Array, before: Array | None, dt_s: float) -> float:
        """Return by how much an input is beyond a limit, as a share of that limit; 0 or less within all.

        Args:
            u: The input.
            before: Input in force until then; ``None`` if there was none.
            dt_s: Period, s.
        """
        magnitude = np.array(self.magnitude)
        beyond = float((np.abs(u) / magnitude).max()) - 1
        if self.norm is not None:
            beyond = max(beyond, float(np.linalg.norm(u)) / self.norm - 1)
        if self.rate_per_s is not None and before is not None:
            step = dt_s * np.array(self.rate_per_s)
            # A difference of two inputs is known to the rounding of the inputs themselves.
            excess = np.abs(u - before) - step - 4 * np.finfo(float).eps * magnitude
            beyond = max(beyond, float((excess / step).max()))
        return beyond


def shortest_input(G: Array, c: Array) -> Array:
    """Return the length of the shortest u with G u + c ≥ 0 in each state, shape (count,); ∞ where there is none.

    Args:
        G: Shape (count, rows, m) with m = 1 or 2.
        c: Shape (count, rows).
    """
    length = np.linalg.norm(G, axis=2)
    is_row = length > 1e-12 * (1 + np.abs(c))
    unit = np.where(is_row[..., None], G / np.where(is_row, length, 1.0)[..., None], 0.0)
    bound = np.where(is_row, -c / np.where(is_row, length, 1.0), np.where(c >= -KEPT, -1.0, HOPELESS))
    candidates = [np.zeros((len(G), 1, G.shape[2])), unit * np.where(is_row, bound, 0.0)[..., None]]
    if G.shape[2] == PLANE:
        candidates += [_corner(unit, bound, i, j)[:, None] for i, j in combinations(range(G.shape[1]), 2)]
    u = np.nan_to_num(np.concatenate(candidates, axis=1), nan=0.0, posinf=0.0, neginf=0.0)
    missed = bound[:, None, :] - np.einsum("sri,sci->scr", unit, u)
    is_kept = (missed <= KEPT * (1 + np.abs(bound[:, None, :]))).all(axis=2)
    return np.asarray(np.where(is_kept, np.linalg.norm(u, axis=2), np.inf).min(axis=1))


def _corner(unit: Array, bound: Array, i: int, j: int) -> Array:
    determinant = unit[:, i, 0] * unit[:, j, 1] - unit[:, i, 1] * unit[:, j, 0]
    safe = np.where(np.abs(determinant) > PARALLEL, determinant, np.inf)
    first = (bound[:, i] * unit[:, j, 1] - bound[:, j] * unit[:, i, 1]) / safe
    second = (bound[:, j] * unit[:, i, 0] - bound[:, i] * unit[:, j, 0]) / safe
    return np.stack([first, second], axis=1)


class AdmissibleInput:
    """Finds out where rows can be kept."""

    def __init__(self, system: System, chains: Sequence[RandomChain], scale: Sequence[float], *, affine: bool) -> None:
        """Compile the rows.

        Args:
            system: The plant.
            chains: Of its barriers.
            scale: Unit of each axis of u.
            affine: Whether f is affine in u.
        """
        self._m, self._scale, self._affine = system.m, np.array(scale), affine
        rows = ca.vertcat(*(chain.held for chain in chains))
        self._rows = ca.Function("rows", [system.x, system.u], [ca.densify(ca.substitute(rows, system.t, 0))])

    def demand(self, states: Array) -> Array:
        """Return the length of the shortest input that keeps all rows, in the units of ``scale``, shape (count,).

        Only for dynamics affine in u.

        Args:
            states: Shape (n, count).
        """
        G, c = self._affine_rows(states)
        return shortest_input(G, c)

    def exists(self, states: Array, limits: InputLimits) -> Array:
        """Return where some input within magnitude and norm keeps all rows, shape (count,), booleans.

        Args:
            states: Shape (n, count).
            limits: The limits; that of the rate is left out.
        """
        bound = np.array(limits.magnitude)
        if not self._affine or (limits.norm is not None and np.ptp(self._scale) > 0):
            return self._on_the_grid(states, limits)
        G, c = self._affine_rows(states)
        box = np.concatenate([np.eye(self._m), -np.eye(self._m)])
        G = np.concatenate([G, np.broadcast_to(box, (len(G), *box.shape))], axis=1)
        edges = np.tile(bound / self._scale, 2)
        length = shortest_input(G, np.concatenate([c, np.broadcast_to(edges, (len(c), len(edges)))], axis=1))
        longest = np.inf if limits.norm is None else limits.norm / self._scale[0] * (1 + KEPT)
        return np.asarray(np.isfinite(length) & (length <= longest))

    def _affine_rows(self, states: Array) -> tuple[Array, Array]:
        at_zero = self._evaluate(states, np.zeros(self._m))
        steps = [self._evaluate(states, self._scale * axis) - at_zero for axis in np.eye(self._m)]
        return np.stack([step.T for step in steps], axis=2), at_zero.T

    def _on_the_grid(self, states: Array, limits: InputLimits) -> Array:
        axes = [np.linspace(-bound, bound, GRID[self._m]) for bound in limits.magnitude]
        inputs = np.stack([axis.ravel() for axis in np.meshgrid(*axes)])
        if limits.norm is not None:
            inputs = inputs[:, np.linalg.norm(inputs, axis=0) <= limits.norm]
        exists = [
            (np.asarray(self._rows(ca.DM(state), ca.DM(inputs))).min(axis=0) >= -KEPT).any() for state in states.T
        ]
        return np.array(exists, dtype=bool)

    def _evaluate(self, states: Array, u: Array) -> Array:
        return np.asarray(self._rows(ca.DM(states), ca.DM(u)))
