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

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.courses.rest_point import Coordinates, RestPoint, depends, rest_point
from passafe.design import FilterDesign
from passafe.enclosures.enclosure import enclose
from passafe.numerics.fixed_order import largest_gain
from passafe.numerics.workspace import Array, BlockLayout, Workspace, dense_function

WIDER: Final = 2.0
"""Factor on all radii, for what lies between samples and for what the map is not linear in."""

ANYWHERE: Final = 1e9
"""Radius of a coordinate that may drift wherever it goes."""


class Settling:
    """Judge of whether a course of the backup law keeps every barrier from a state on.

    Attributes:
        may_tell: Whether there is a state to settle in where no barrier drifts or falls.
        is_static: Whether no barrier moves by itself.
    """

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
        after = step(state, 0)[0]
        linearize = dense_function("linearize", [state], [after, ca.jacobian(after, state)])
        branches = [[_Branch.of(design, branch.psi[0], state) for branch in chain.branches] for chain in chains]
        self.is_static = not any(branch.moves_with[system.n] for each in branches for branch in each)
        coordinates = Coordinates.of(system, law)
        rest = rest_point(linearize, coordinates)
        space = self._space = Workspace(BlockLayout.of({"state": state.numel(), "lowest": 1}))
        self._state, self._lowest = space.part("state"), space.part("lowest")
        self.may_tell = rest is not None and all(
            any(branch.may_stay(state, rest) for branch in chain) for chain in branches
        )
        if rest is None or not self.may_tell:
            return
        lowest = _lowest_within(branches, state, rest)
        as_at_rest, everywhere = (_judge(rest, coordinates, linearize, lowest, nearby=each) for each in (False, True))
        self._judge_as_at_rest = space.bind(as_at_rest, ("state",), ("lowest",))
        self._judge = space.bind(everywhere, ("state",), ("lowest",))

    def may_keep(self, state: Array) -> bool:
        """Return whether every barrier would be kept for ever if the map were nowhere steeper than at rest.

        Where it is not, ``lowest`` is negative, too; this takes no slopes.

        Args:
            state: x, t and the u in force, shape (n + 1 + m,).
        """
        return self.may_tell and self._lowest_by(self._judge_as_at_rest, state) >= 0

    def lowest(self, state: Array) -> float:
        """Return a lower bound of every h from here on for ever; −∞ where none is known.

        Args:
            state: x, t and the u in force, shape (n + 1 + m,).
        """
        return self._lowest_by(self._judge, state) if self.may_tell else -np.inf

    def _lowest_by(self, judge: Callable[[], None], state: Array) -> float:
        self._state[:] = state
        judge()
        return float(self._lowest[0])


class _Branch(NamedTuple):
    """One h: its value and slope over time, and which coordinates of (x, t, u) it depends on."""

    h: ca.SX
    rate: ca.SX
    moves_with: list[bool]

    @classmethod
    def of(cls, design: FilterDesign, h: ca.SX, state: ca.SX) -> "_Branch":
        return cls(h, design.system.rate(h), depends(ca.vertcat(h), state))

    def drifts(self, rest: RestPoint) -> bool:
        """Return whether it depends on a coordinate that drifts."""
        return bool((self.moves_with & rest.drifts).any())

    def may_stay(self, state: ca.SX, rest: RestPoint) -> bool:
        """Return whether it stays as it is at rest, or does not fall while others drift."""
        if not self.drifts(rest):
            return True
        rate = self.least_rate(state, rest, ca.SX.zeros(state.numel()))
        return float(ca.Function("rate", [state], [rate])(rest.state)) >= 0

    def least_rate(self, state: ca.SX, rest: RestPoint, radius: ca.SX) -> ca.SX:
        """Return the least ḣ within the radius, and wherever others drift."""
        wherever = [ANYWHERE if drifts else radius[i] for i, drifts in enumerate(rest.drifts)]
        return _least(self.rate, state, ca.vertcat(*wherever))


def _least(expression: ca.SX, state: ca.SX, radius: ca.SX) -> ca.SX:
    ball = enclose(ca.vertcat(expression), state, radius)
    return ca.if_else(ball.known, ball.centre - ball.radius, -ca.inf)


def _lowest_within(chains: Sequence[Sequence[_Branch]], state: ca.SX, rest: RestPoint) -> ca.Function:
    """Return the function from state and radius to the least over all chains of their largest branch."""
    radius, lowest = ca.SX.sym("radius", state.numel()), ca.SX(ca.inf)
    for chain in chains:
        kept = [ca.if_else(each.least_rate(state, rest, radius) >= 0, each.h, -ca.inf) for each in chain]
        kept += [_least(each.h, state, radius) for each in chain if not each.drifts(rest)]
        lowest = ca.fmin(lowest, reduce(ca.fmax, kept))
    return dense_function("lowest", [state, radius], [lowest])


def _judge(
    rest: RestPoint, place: Coordinates, linearize: ca.Function, lowest: ca.Function, *, nearby: bool
) -> ca.Function:
    """Return the function from a state to the lower bound of every h from there on; −∞ where the map does not contract.

    Args:
        rest: Where courses settle.
        place: Of the coordinates.
        linearize: Gives the slope of the map.
        lowest: From a state and how far each coordinate may still move, to the least h.
        nearby: Whether slopes count where the course is now and halfway to rest, besides those at rest.
    """
    state = ca.MX.sym("state", len(rest.state))
    q, r = place.q.tolist(), place.r.tolist()
    settled = ca.DM(rest.state[place.r])
    halfway = ca.MX(state)
    halfway[r] = (state[r] + settled) / 2
    slopes: list[ca.DM | ca.MX] = [ca.DM(rest.slope)]
    if nearby:
        slopes += [ca.mtimes(linearize(each)[1][:, r], ca.diag(ca.DM(rest.scale))) for each in (halfway, state)]
    in_norm = [slope @ ca.DM(rest.inverse_root) for slope in slopes]
    gain = largest_gain(len(r))
    gains = [gain(ca.DM(rest.root) @ (each[r, :] / ca.repmat(ca.DM(rest.scale), 1, len(r)))) for each in in_norm]
    contracts = reduce(ca.logic_and, (each < 1 for each in gains))  # a NaN does not
    contraction = reduce(ca.fmax, gains)
    travel = reduce(ca.fmax, (ca.sqrt(ca.sum2(each[q, :] ** 2)) for each in in_norm))
    deviation = (state[r] - settled) / ca.DM(rest.scale)
    size = ca.norm_2(ca.DM(rest.root) @ deviation)
    reach = ca.fabs(deviation) + ca.DM(np.linalg.norm(rest.inverse_root, axis=1)) * size
    radius = ca.MX.zeros(len(rest.state))
    radius[r] = WIDER * ca.DM(rest.scale) * reach
    radius[q] = WIDER * travel * size / (1 - contraction)
    found = ca.if_else(ca.MX(contracts), lowest(state, radius), -ca.inf)
    return ca.Function("judge", [state], [ca.densify(found)])
