"""The end of a course of the backup law: where it settles, and whether every barrier is kept from there on for ever.

Coordinates on which neither the dynamics nor the law depend, such as a place or a gap, are *ignorable*: they integrate
the others (Goldstein, Poole & Safko 2002, section 2.6). A robot may rest while they drift on, as a car behind another
one does. The others and the input, together r, settle where the period's map r⁺(r) contracts. With

    r* = r⁺(r*),  A = ∂r⁺/∂r,  AᵀPA/μ² = P − I,  ‖d‖_P² = dᵀPd,  λ = max ‖Ad‖_P/‖d‖_P,

and μ halfway between A's spectral radius and one, every later r lies in

    |r − r*|_i ≤ √(P⁻¹)_ii·‖r − r*‖_P

(Lyapunov; Khalil 2002, section 4.9). An ignorable coordinate q⁺ = q + c + B(r − r*) that does not drift, c = 0, travels
by no more than ‖B_i‖_{P⁻¹}·‖r − r*‖_P/(1 − λ). So a barrier is kept for ever if its h is not negative within these
radii, or if ḣ is not wherever the others drift.

A and B are taken where the course settles, where it is now and halfway between, and λ is their largest gain: the slope
of the map elsewhere is not looked at. Radii are twice as wide to cover what lies between samples.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign
from passafe.enclosure import enclose
from passafe.fixed_order import (
    balancing,
    cholesky,
    largest_gain,
    least_squares,
    length,
    product,
    solution,
    spectral_radius,
)
from passafe.system import System
from passafe.workspace import Array, BlockLayout, Workspace, dense_function

SLOWEST: Final = 1 - 1e-7
"""Largest contraction in a period that counts as one."""

STILL: Final = 1e-11
"""Drift in a period, relative to 1 + |q|, that counts as none."""

SMALLEST: Final = 1e-12
"""Deviation from rest, relative to 1 + |r|, below which all are alike: rounding."""

WIDER: Final = 2.0
"""Factor on all radii, for what lies between samples and for what the map is not linear in."""

ANYWHERE: Final = 1e9
"""Radius of a coordinate that may drift wherever it goes."""

NEWTON_STEPS: Final = 8


Flags = NDArray[np.bool_]
"""Array of booleans."""


class _RestPoint(NamedTuple):
    """State in which r settles, and the norm in which it does: the same from wherever the course comes.

    Attributes:
        r: Settled coordinates, shape (k,).
        scale: Unit of each of them, shape (k,).
        slope: Of the period's map there, by r in these units, shape (n + 1 + m, k).
        root: R with P = RᵀR.
        inverse_root: R⁻¹.
        drifts: Where a coordinate drifts, booleans, shape (n + 1 + m,).
    """

    r: Array
    scale: Array
    slope: Array
    root: Array
    inverse_root: Array
    drifts: Flags


class Settling:
    """Judge of whether a course of the backup law keeps every barrier from a state on."""

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain], step: ca.Function, law: ca.SX) -> None:
        """Derive the slope of the period's map, and the bounds of every barrier around a state.

        Args:
            design: The filter's.
            chains: Chains of the barriers that are to be kept.
            step: One period, from (x, t, u) and 0 to the next (x, t, u), as its first result.
            law: The input that the backup law sends, expression of x, t and the u before.
        """
        system = design.system
        state = ca.vertcat(system.x, system.t, system.u)
        self._n = system.n
        free, shallow = _ignorable(system, law)
        self._ignorable = np.array([*free, True, *[False] * system.m])
        self._q, self._r = np.flatnonzero(self._ignorable), np.flatnonzero(~self._ignorable)
        self._is_bounded = np.array([*shallow, False, *[True] * system.m])
        self._members = [len(chain.branches) for chain in chains]
        branches = [branch.psi[0] for chain in chains for branch in chain.branches]
        after = step(state, 0)[0]
        slope = ca.jacobian(after, state)
        radius, wherever = ca.SX.sym("radius", state.numel()), ca.SX.sym("wherever", state.numel())
        bounds = _bounds(branches, [system.rate(h) for h in branches], state, radius, wherever)
        self._moves_with = np.array([_depends(ca.vertcat(h), state) for h in branches]).reshape(-1, state.numel())
        size = int(state.numel())
        space = Workspace(
            BlockLayout.of(
                {
                    "state": size,
                    "radius": size,
                    "wherever": size,
                    "after": size,
                    "slope": (size, size),
                    "bounds": (3, len(branches)),
                    "map": (len(self._r), len(self._r)),
                    "gain": 1,
                }
            )
        )
        self._state, self._after = space.part("state"), space.part("after")
        self._radius, self._wherever = space.part("radius"), space.part("wherever")
        self._slope, self._bounds = space.view("slope"), space.view("bounds")
        linearize = dense_function("linearize", [state], [after, slope])
        self._linearize = space.bind(linearize, ("state",), ("after", "slope"))
        bound = dense_function("bound", [state, radius, wherever], [bounds])
        self._bound = space.bind(bound, ("state", "radius", "wherever"), ("bounds",))
        self._map, self._gain = space.view("map"), space.part("gain")
        self._write_gain = space.bind(largest_gain(len(self._r)), ("map",), ("gain",))
        self._space = space  # holds what the calls above write to
        self._rest = self._rest_point()

    @property
    def is_static(self) -> bool:
        """True if no barrier moves by itself."""
        return not self._moves_with[:, self._n].any()

    @property
    def may_tell(self) -> bool:
        """True if there is a state to settle in where no barrier drifts or falls."""
        return self._rest is not None

    def lowest(self, state: Array) -> float:
        """Return a lower bound of every h from here on for ever; −∞ where none is known.

        Args:
            state: x, t and the u in force, shape (n + 1 + m,).
        """
        radius = None if self._rest is None else self._radius_towards(self._rest, state)
        if self._rest is None or radius is None:
            return -np.inf
        now, nearby, slope = self._bounds_around(self._rest, state, radius)
        stays = np.where(self._drifts(self._rest), -np.inf, nearby)
        rises = np.where(slope >= 0, now, -np.inf)
        return self._lowest_of_chains(np.maximum(stays, rises))

    def _drifts(self, rest: _RestPoint) -> Flags:
        """Return which branches depend on a coordinate that drifts, booleans."""
        return np.asarray((self._moves_with & rest.drifts).any(axis=1), dtype=bool)

    def _bounds_around(self, rest: _RestPoint, state: Array, radius: Array) -> Array:
        """Return h now, the least h within the radius, and the least ḣ wherever others drift, shape (3, branches)."""
        self._state[:], self._radius[:] = state, radius
        self._wherever[:] = np.where(rest.drifts, ANYWHERE, radius)
        self._bound()
        return self._bounds

    def _lowest_of_chains(self, branches: Array) -> float:
        """Return the least over all chains of their largest branch; ∞ without a chain."""
        parts = np.split(branches, np.cumsum(self._members)[:-1]) if self._members else []
        return min((float(part.max()) for part in parts), default=np.inf)

    def _radius_towards(self, rest: _RestPoint, state: Array) -> Array | None:
        """Return how far the state may still move, shape (n + 1 + m,); ``None`` where the map does not contract.

        Drifting coordinates have any radius.
        """
        deviation = (state[self._r] - rest.r) / rest.scale
        halfway = state.copy()
        halfway[self._r] = (state[self._r] + rest.r) / 2
        nearby = [self._slope_at(each)[:, self._r] * rest.scale for each in (halfway, state)]
        slopes = product(np.stack([rest.slope, *nearby]), rest.inverse_root)
        maps = product(rest.root, slopes[:, self._r] / rest.scale[:, None])
        contraction = max(self._largest_gain(each) for each in maps)
        if contraction >= 1:
            return None
        size = length(product(rest.root, deviation))
        travel = np.linalg.norm(slopes[:, self._q], axis=2).max(axis=0)
        radius = np.zeros(len(state))
        reach = np.abs(deviation) + np.linalg.norm(rest.inverse_root, axis=1) * size
        radius[self._r] = WIDER * rest.scale * reach
        radius[self._q] = WIDER * travel * size / (1 - contraction)
        return radius

    def _rest_point(self) -> _RestPoint | None:
        """Return where courses settle; ``None`` if they do not, or if a barrier cannot stay there."""
        end = self._fixed_point(np.zeros(len(self._state)))
        if end is None:
            return None
        q, r = self._q, self._r
        slope, drift = self._slope_at(end)[:, r], (self._after - end)[q]
        rate = _spectral_radius(slope[r])
        if rate >= SLOWEST:
            return None
        scale = balancing(slope[r])
        slope = slope * scale
        root = _root(slope[r] / scale[:, None] / ((1 + rate) / 2))
        drifts = np.zeros(len(end), dtype=bool)
        drifts[q] = ~self._is_bounded[q] | (np.abs(drift) > STILL * (1 + np.abs(end[q])))
        inverse_root = least_squares(root, np.eye(len(root)))
        rest = _RestPoint(end[r], scale, slope, root, inverse_root, drifts)
        slope_of_h = self._bounds_around(rest, end, np.zeros(len(end)))[2]
        can_stay = np.where(self._drifts(rest), slope_of_h, np.inf)
        return rest if self._lowest_of_chains(can_stay) >= 0 else None

    def _fixed_point(self, state: Array) -> Array | None:
        """Return where r settles by Newton's method, shape (n + 1 + m,); ``None`` where it does not."""
        r = self._r
        end = state.copy()
        for _ in range(NEWTON_STEPS):
            slope = self._slope_at(end)[np.ix_(r, r)]
            change = (self._after - end)[r]
            if not (np.isfinite(slope).all() and np.isfinite(change).all()):
                return None
            step = solution(np.eye(len(r)) - slope, change)
            if step is None:  # rests side by side: no single point
                return None
            end[r] += step
            if (np.abs(step) <= SMALLEST * (1 + np.abs(end[r]))).all():
                return end
        return None

    def _largest_gain(self, A: Array) -> float:
        """Return ‖A‖₂; infinite where it is not finite."""
        if not np.isfinite(A).all():
            return np.inf
        self._map[:] = A
        self._write_gain()
        return float(self._gain[0])

    def _slope_at(self, state: Array) -> Array:
        self._state[:] = state
        self._linearize()
        return self._slope.copy()


def _spectral_radius(A: Array) -> float:
    """Return the largest magnitude of an eigenvalue; infinite where A is not finite."""
    return spectral_radius(A) if np.isfinite(A).all() else np.inf


def _root(A: Array) -> Array:
    """Return an upper triangular R with RᵀR = P = Σ (Aᵏ)ᵀAᵏ, the solution of AᵀPA = P − I, for a radius below one."""
    P, power = np.eye(len(A)), A
    while np.abs(power).max(initial=0.0) >= SMALLEST:
        P = P + product(power.T, product(P, power))
        power = product(power, power)
    return cholesky(P)


def _ignorable(system: System, law: ca.SX) -> tuple[Flags, Flags]:
    """Return which coordinates of x are ignorable, and which depend on no ignorable one; booleans, shape (n,).

    One that only ignorable ones depend on, such as a speed that nothing brakes, is ignorable, too.
    """
    uses = np.array([_depends(row, system.x) for row in ca.vertsplit(ca.vertcat(system.f, law))])
    rates, inputs = uses[: system.n], uses[system.n :].any(axis=0)
    free = np.zeros(system.n, dtype=bool)
    for _ in range(system.n):
        free = ~inputs & ~rates[~free].any(axis=0) & ~rates.diagonal()
    return free, np.logical_not(rates[:, free].any(axis=1))


def _depends(expression: ca.SX, symbols: ca.SX) -> list[bool]:
    """Return which symbols an expression depends on."""
    return [bool(each) for each in ca.which_depends(expression, symbols, 1, False)] if symbols.numel() else []


def _bounds(branches: Sequence[ca.SX], rates: Sequence[ca.SX], state: ca.SX, near: ca.SX, wherever: ca.SX) -> ca.SX:
    """Return h now, the least h nearby and the least ḣ wherever others drift, by branch; −∞ where not known."""
    columns = [
        ca.vertcat(h, _lowest(h, state, near), _lowest(rate, state, wherever))
        for h, rate in zip(branches, rates, strict=True)
    ]
    return ca.horzcat(*columns) if columns else ca.SX(3, 0)


def _lowest(expression: ca.SX, state: ca.SX, radius: ca.SX) -> ca.SX:
    ball = enclose(ca.vertcat(expression), state, radius)
    return ca.if_else(ball.known, ball.centre - ball.radius, -ca.inf)
