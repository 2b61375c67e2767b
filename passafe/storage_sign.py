"""Lower bounds of storage functions, and the direction in which one has none.

Passivity limits what leaves the port by what is stored; from a V without a lower bound any amount can be drawn, and the
row means nothing. A quadratic V is judged exactly, by the eigenvalues of its Hessian and its slope where that vanishes;
any other along random directions, by its values ever further out.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import casadi as ca
import numpy as np

from passafe.errors import DesignError
from passafe.workspace import Array

ROUNDING: Final = 1e-9
"""Share of the largest eigenvalue below which one counts as zero."""

DIRECTIONS: Final = 200
SCALES: Final = (1.0, 1e1, 1e2, 1e3)


@dataclass(frozen=True, kw_only=True, slots=True)
class Descent:
    """A direction along which V falls without end.

    Attributes:
        direction: Unit vector of the state space, n numbers.
        values: V at the distances ``SCALES`` along it, J.
    """

    direction: tuple[float, ...]
    values: tuple[float, ...]

    def __str__(self) -> str:
        """Return it in words."""
        direction = ", ".join(f"{value:.3g}" for value in self.direction)
        near, far = self.values[1:3]
        return f"V = {near:.3g} J at {SCALES[1]:g} and {far:.3g} J at {SCALES[2]:g} times ({direction})"


def descent_of(V: ca.SX, x: ca.SX) -> Descent | None:
    """Return the direction along which V falls most without end, or ``None`` where there is none or none is found.

    Args:
        V: Storage function, scalar expression of x.
        x: State symbol, shape (n, 1).
    """
    value = ca.Function("V", [x], [V])
    if ca.is_quadratic(V, x):
        hessian, slope = (part.full() for part in ca.Function("bend", [x], ca.hessian(V, x))(0))
        directions = _of_quadratic(hessian, slope.ravel())
    else:
        directions = np.random.default_rng(1).normal(size=(DIRECTIONS, x.numel()))
    descents = []
    for direction in directions / np.linalg.norm(directions, axis=1, keepdims=True):
        values = tuple(float(value(scale * direction)) for scale in SCALES)
        if values[-1] < 0 and all(after < before for before, after in pairwise(values)):
            descents.append(Descent(direction=tuple(direction.tolist()), values=values))
    return min(descents, key=lambda descent: descent.values[-1], default=None)


def require_lower_bound(V: ca.SX, x: ca.SX) -> None:
    """Refuse a storage function that falls without end: energy without end may be drawn from it.

    Args:
        V: Storage function, scalar expression of x.
        x: State symbol, shape (n, 1).

    Raises:
        DesignError: It does; the message has a direction and values of V along it.
    """
    descent = descent_of(V, x)
    if descent is not None:
        raise DesignError("passivity V", f"{descent}", "a V that is bounded from below, such as a sum of squares")


def _of_quadratic(hessian: Array, slope: Array) -> Array:
    """Return the directions in which a quadratic V curves least, and in which it falls where it does not curve."""
    eigenvalues, vectors = np.linalg.eigh(hessian)
    flat = vectors[:, np.abs(eigenvalues) <= ROUNDING * max(float(np.abs(eigenvalues).max()), 1e-300)]
    falling = -flat @ (flat.T @ slope)
    directions = [vectors[:, 0], -vectors[:, 0]] if eigenvalues[0] < 0 else []
    if np.linalg.norm(falling) > 0:
        directions.append(falling)
    return np.array(directions).reshape(-1, len(hessian))
