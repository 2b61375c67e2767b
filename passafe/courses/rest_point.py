"""The state in which a backup law's course settles, and the norm in which it does: the same from wherever it comes."""

from typing import Final, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.numerics.fixed_order import balancing, cholesky, least_squares, product, solution, spectral_radius
from passafe.numerics.workspace import Array
from passafe.system import System

SLOWEST: Final = 1 - 1e-7
"""Largest contraction in a period that counts as one."""

STILL: Final = 1e-11
"""Drift in a period, relative to 1 + |q|, that counts as none."""

SMALLEST: Final = 1e-12
"""Deviation from rest, relative to 1 + |r|, below which all are alike: rounding."""

NEWTON_STEPS: Final = 8

Flags = NDArray[np.bool_]
"""Array of booleans."""

Places = NDArray[np.intp]
"""Array of places in (x, t, u)."""


class Coordinates(NamedTuple):
    """Coordinates of (x, t, u): those that integrate the others, and those that settle.

    Attributes:
        q: Places of the ignorable ones; the time is one of them.
        r: Places of the others.
        is_bounded: Whether each does not drift for ever if the others rest, booleans, shape (n + 1 + m,).
    """

    q: Places
    r: Places
    is_bounded: Flags

    @classmethod
    def of(cls, system: System, law: ca.SX) -> "Coordinates":
        """Return the coordinates of a system under a law.

        One that only ignorable ones depend on, such as a speed that nothing brakes, is ignorable, too.
        """
        uses = np.array([depends(row, system.x) for row in ca.vertsplit(ca.vertcat(system.f, law))])
        rates, inputs = uses[: system.n], uses[system.n :].any(axis=0)
        free = np.zeros(system.n, dtype=bool)
        for _ in range(system.n):
            free = ~inputs & ~rates[~free].any(axis=0) & ~rates.diagonal()
        shallow = np.logical_not(rates[:, free].any(axis=1))
        ignorable = np.array([*free, True, *[False] * system.m])
        is_bounded = np.array([*shallow, False, *[True] * system.m])
        return cls(np.flatnonzero(ignorable), np.flatnonzero(~ignorable), is_bounded)


class RestPoint(NamedTuple):
    """State in which r settles, and the norm in which it does.

    Attributes:
        state: (x, t, u) there, shape (n + 1 + m,).
        scale: Unit of each coordinate of r, shape (k,).
        slope: Of the period's map there, by r in these units, shape (n + 1 + m, k).
        root: R with P = RᵀR.
        inverse_root: R⁻¹.
        drifts: Where a coordinate drifts, booleans, shape (n + 1 + m,).
    """

    state: Array
    scale: Array
    slope: Array
    root: Array
    inverse_root: Array
    drifts: Flags


def rest_point(linearize: ca.Function, coordinates: Coordinates) -> RestPoint | None:
    """Return where courses settle; ``None`` where there is no such state, or the map does not contract there.

    Args:
        linearize: From (x, t, u) to that one period later, and its slope.
        coordinates: Of (x, t, u).
    """
    q, r, is_bounded = coordinates
    end = _fixed_point(linearize, r)
    if end is None:
        return None
    after, whole_slope = _linearized(linearize, end)
    slope, drift = whole_slope[:, r], (after - end)[q]
    rate = spectral_radius(slope[r]) if np.isfinite(slope[r]).all() else np.inf
    if rate >= SLOWEST:
        return None
    scale = balancing(slope[r])
    slope = slope * scale
    root = _root(slope[r] / scale[:, None] / ((1 + rate) / 2))
    drifts = np.zeros(len(end), dtype=bool)
    drifts[q] = ~is_bounded[q] | (np.abs(drift) > STILL * (1 + np.abs(end[q])))
    return RestPoint(end, scale, slope, root, least_squares(root, np.eye(len(root))), drifts)


def _fixed_point(linearize: ca.Function, r: Places) -> Array | None:
    """Return where r settles by Newton's method, shape (n + 1 + m,); ``None`` where it does not."""
    end = np.zeros(linearize.size1_in(0))
    for _ in range(NEWTON_STEPS):
        after, whole_slope = _linearized(linearize, end)
        slope, change = whole_slope[np.ix_(r, r)], (after - end)[r]
        if not (np.isfinite(slope).all() and np.isfinite(change).all()):
            return None
        step = solution(np.eye(len(r)) - slope, change)
        if step is None:  # rests side by side: no single point
            return None
        end[r] += step
        if (np.abs(step) <= SMALLEST * (1 + np.abs(end[r]))).all():
            return end
    return None


def _linearized(linearize: ca.Function, state: Array) -> tuple[Array, Array]:
    after, slope = linearize(ca.DM(state))
    return after.full().ravel(), slope.full()


def _root(A: Array) -> Array:
    """Return an upper triangular R with RᵀR = P = Σ (Aᵏ)ᵀAᵏ, the solution of AᵀPA = P − I, for a radius below one."""
    P, power = np.eye(len(A)), A
    while np.abs(power).max(initial=0.0) >= SMALLEST:
        P = P + product(power.T, product(P, power))
        power = product(power, power)
    return cholesky(P)


def depends(expression: ca.SX, symbols: ca.SX) -> list[bool]:
    """Return which symbols an expression depends on."""
    return [bool(each) for each in ca.which_depends(expression, symbols, 1, False)] if symbols.numel() else []
