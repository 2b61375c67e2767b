"""Lower bounds of storage functions, and the direction in which one has none.

Passivity limits what leaves the port by what is stored; from a V without a lower bound any amount can be drawn, and the
row means nothing. A quadratic V is judged exactly, by the eigenvalues of its Hessian and its slope where that vanishes;
any other along the axes, the directions in which it curves least far out, and random ones, by its values ever further
out: it falls without end where its fall over one decade of distance is no less than half of that over the one before.
"""

from dataclasses import dataclass
from typing import Final

import casadi as ca
import numpy as np

from passafe.errors import DesignError
from passafe.numerics.workspace import Array

ROUNDING: Final = 1e-9
"""Share of the largest eigenvalue below which one counts as zero."""

DIRECTIONS: Final = 200

SCALES: Final = (1.0, 1e1, 1e2, 1e3)
"""Distances at which a descent is reported, and at which directions of least curvature are looked for."""

DECADE: Final = 6
"""Distances that V is looked at within a factor of ten."""

DISTANCES: Final = np.geomspace(1.0, 1e6, 6 * DECADE + 1)


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
        shown = 1 if self.values[2] < min(self.values[1], 0.0) else 2
        near, far = self.values[shown : shown + 2]
        return f"V = {near:.3g} J at {SCALES[shown]:g} and {far:.3g} J at {SCALES[shown + 1]:g} times ({direction})"


def descent_of(V: ca.SX, x: ca.SX) -> Descent | None:
    """Return the direction along which V falls most without end, or ``None`` where there is none or none is found.

    Args:
        V: Storage function, scalar expression of x.
        x: State symbol, shape (n, 1).
    """
    value = ca.Function("V", [x], [V])
    if _is_quadratic(value, V, x):
        hessian, slope = (part.full() for part in ca.Function("bend", [x], ca.hessian(V, x))(0))
        directions = _of_quadratic(hessian, slope.ravel())
    else:
        directions = _of_any(V, x)
    descents = []
    along = value.map(len(DISTANCES))
    for direction in directions / np.linalg.norm(directions, axis=1, keepdims=True):
        if _falls_without_end(along(np.outer(direction, DISTANCES)).full().ravel()):
            values = tuple(float(value(scale * direction)) for scale in SCALES)
            descents.append(Descent(direction=tuple(direction.tolist()), values=values))
    return min(descents, key=lambda descent: descent.values[-1], default=None)


def _is_quadratic(value: ca.Function, V: ca.SX, x: ca.SX) -> bool:
    """Return whether V is quadratic; |x| is by its derivatives, and by its values not."""
    if not ca.is_quadratic(V, x):
        return False
    probes = np.random.default_rng(2).normal(size=(x.numel(), 4))
    there, back, twice, centre = (value.map(4)(s * probes).full() for s in (1.0, -1.0, 2.0, 0.0))
    size = np.abs(np.concatenate([there, back, twice, centre])).max()
    return bool((np.abs(twice - 3 * there - back + 3 * centre) <= ROUNDING * size).all())


def _falls_without_end(values: Array) -> bool:
    """Return whether values at ``DISTANCES`` end below zero, and fall over their last decade as over that before."""
    finite = np.isfinite(values)
    end = len(values) if finite.all() else int(finite.argmin())
    if end <= 2 * DECADE:
        return False
    last, before, first = values[end - 1], values[end - 1 - DECADE], values[end - 1 - 2 * DECADE]
    is_falling = bool((np.diff(values[end - 1 - 2 * DECADE : end]) < 0).all())
    return is_falling and last < 0 and before - last >= (first - before) / 2


def _of_any(V: ca.SX, x: ca.SX) -> Array:
    """Return the axes, the directions of least curvature and of steepest descent at random states, and random ones."""
    axes = np.eye(x.numel())
    random = np.random.default_rng(1).normal(size=(DIRECTIONS, x.numel()))
    bend = ca.Function("bend", [x], ca.hessian(V, x))
    found = [*axes, *-axes, *random]
    for scale in SCALES:
        for state in random[: DIRECTIONS // 10]:
            hessian, slope = (part.full() for part in bend(scale * state))
            if np.isfinite(hessian).all() and np.isfinite(slope).all():
                least = np.linalg.eigh(hessian)[1][:, 0]
                steepest = np.abs(slope).max()
                found += [least, -least, *([-slope.ravel() / steepest] if steepest else [])]
    return np.array(found)


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
