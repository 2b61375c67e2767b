"""The distance of the hard rows from a conflict within the limits: a linear program, with proof.

    max t  subject to  gᵢᵀw − dᵢ ≥ t for every hard row,  u_ref + w within the limits.

Rows are of unit length, so t is in units of u: the largest distance that some admissible input can keep from all hard
rows at once. Where it is negative, no admissible input keeps them, and −t is the least by which the worst is missed.
Rows are meant as they stand at the decision, with tangents and margins between samples that suit inputs near u⁺.

Often one row decides: the upper bound that it proves alone, the most that it can be kept by within the axes' limits, is
reached where it is kept that well, and no other row is missed by more there. Otherwise the program is solved.

DAQP solves strictly convex programs, so the linear one is solved by proximal points, min ½‖z − c‖² − t/η with
z = (w, t) and c the answer before; for a linear program that ends after finitely many steps (Rockafellar 1976), nearly
always the first. No answer is trusted: the value of any admissible w is a lower bound of the maximum, and any
weights μ ≥ 0 with Σμ = 1 give the upper bound max_w Σμᵢ(gᵢᵀw − dᵢ), which has a closed form over the limits.
"""

from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import Final

import daqp
import numpy as np
from msgspec import Struct

from passafe.admissible_shapes import NormBound
from passafe.decision import Decision
from passafe.limits import ROUNDING, Limits
from passafe.numerics.fixed_order import inner, length, product
from passafe.numerics.workspace import Array

ETA: Final = 1e-8
"""η: price of being away from c, lengths measured in the reach of the limits."""

ATTEMPTS: Final = 8
"""Proximal steps, at most; each puts two tangents of every norm."""

CLOSED: Final = 1e-8
"""Gap between the bounds, relative to the reach, at which no better ones are sought."""

DRAWN_IN: Final = 1e-9
"""Distance from a half-space to which a point beyond it is drawn in, relative to the reach."""

_FAR: Final = 1e30
_SOLVED: Final = 1


@dataclass(frozen=True, kw_only=True, slots=True)
class Distance:
    """Proven bounds of the largest t.

    Attributes:
        lower: Some admissible input keeps every hard row with this much to spare, units of u.
        upper: None keeps them with more.
    """

    lower: float
    upper: float


class _Program(Struct, frozen=True, eq=False):
    """The linear program of one decision, in w."""

    G: Array
    d: Array
    u_ref: Array
    low: Array
    high: Array
    limits: Limits

    def kept(self, w: Array) -> float:
        """Return by how much w keeps the row that it keeps least."""
        return float(np.minimum.reduce(product(self.G, w) - self.d))

    def admissible(self, w: Array, known: Array) -> Array:
        """Return the last admissible point on the segment from an admissible one to w."""
        reach = self.limits.reach
        for half_space in self.limits.half_spaces:  # on a plane already, a way that ends past it has no admissible part
            missed = inner(np.array(half_space.weights), self.u_ref + w) - half_space.bound
            if missed > 0.0:
                w = w - (missed + DRAWN_IN * reach) * np.array(half_space.weights)
        w = np.minimum(np.maximum(w, self.low), self.high)
        start, step, share = self.u_ref + known, w - known, 1.0
        for norm in self.limits.norms:
            from_, way = start[list(norm.axes)], step[list(norm.axes)]
            a, b, c = inner(way, way), inner(from_, way), max(norm.bound**2 - inner(from_, from_), 0.0)
            if a + 2 * b > c:
                share = min(share, (sqrt(b * b + a * c) - b) / a)
        for half_space in self.limits.half_spaces:
            weights = np.array(half_space.weights)
            slope = inner(weights, step)
            room = max(half_space.bound - inner(weights, start), 0.0)
            if slope > room + ROUNDING * reach:
                share = min(share, room / slope)
        return w if share == 1.0 else known + step * share

    def most(self, pull: Array) -> float:
        """Return the largest pullᵀw over the axes' limits."""
        return float(np.add.reduce(np.maximum(pull * self.low, pull * self.high)))

    def most_in_balls(self, pull: Array) -> float:
        """Return an upper bound of pullᵀw over axes and norms: each axis counts in the first norm it belongs to."""
        over_axes = np.maximum(pull * self.low, pull * self.high)
        most, left = 0.0, np.ones(len(pull), dtype=np.bool_)
        for norm in self.limits.norms:
            axes = [axis for axis in norm.axes if left[axis]]
            left[axes] = False
            in_ball = norm.bound * length(pull[axes]) - inner(pull[axes], self.u_ref[axes])
            most += min(float(np.add.reduce(over_axes[axes])), in_ball)
        return most + float(np.add.reduce(over_axes[left]))


class _Touch(Struct, frozen=True, eq=False):
    """Place at which a norm's limit is touched.

    Attributes:
        norm: The norm.
        unit: Direction over its axes, of unit length.
    """

    norm: NormBound
    unit: Array

    def input(self, w: Array, u_ref: Array) -> Array:
        """Return w with the norm's axes moved there."""
        axes, moved = list(self.norm.axes), w.copy()
        moved[axes] = self.norm.bound * self.unit - u_ref[axes]
        return moved


class DistanceToInfeasibility:
    """Solves the linear program of each decision.

    The answer is a function of the decision alone: the solver starts afresh every time.

    Attributes:
        reach: Largest distance between two inputs within the magnitudes, units of u. No distance to infeasibility is
            larger: without hard rows, or with rows further away than any input can go, it is this.
        floor: Value for rows with a NaN, units of u; no distance is smaller.
    """

    def __init__(self, limits: Limits, hard: int) -> None:
        """Set the solver up.

        Args:
            limits: The filter's.
            hard: Number of hard rows.
        """
        self.reach = limits.reach
        # ‖w‖ ≤ reach, and a bound is drawn in to twice that (``passafe.symbolic.rows.stack``).
        self.floor = -3 * self.reach
        self._limits, self._hard, self._m = limits, hard, len(limits.low)
        self._planes = hard + len(limits.half_spaces)
        rows = self._planes + 2 * ATTEMPTS * len(limits.norms)
        size, count = self._m + 1, self._m + 1 + rows
        self._A, self._rows = (np.zeros((rows, size)) for _ in range(2))
        self._rows[:hard, -1] = -1.0
        for row, half_space in zip(self._rows[hard:], limits.half_spaces, strict=False):
            row[:-1] = np.negative(half_space.weights)
        self._above, self._below = np.full(count, _FAR), np.full(count, -_FAR)
        self._above[self._m], self._below[self._m] = 1.0, -4.0
        self._bounds = self._below[size:]
        self._cold = np.zeros(count, dtype=np.intc)
        self._linear = np.zeros(size)
        self._used = self._planes
        self._model = daqp.Model()
        self._model.setup(np.eye(size), self._linear, self._A, self._above, self._below, self._cold)

    def of(self, decision: Decision) -> Distance:
        """Return the proven bounds of the distance at a decision."""
        if not self._hard:
            return Distance(lower=self.reach, upper=self.reach)
        return self._deepest(decision)[1]

    def deepest(self, decision: Decision) -> Array:
        """Return the admissible input that was found to keep the hard rows of a decision best, shape (m,)."""
        u_plus = decision.part("u_plus")
        return u_plus if not self._hard else self._deepest(decision)[0] + decision.part("u_ref")

    def _deepest(self, decision: Decision) -> tuple[Array, Distance]:
        u_ref = decision.part("u_ref")
        program = _Program(
            G=decision.view("G")[: self._hard, : self._m],
            d=decision.part("d")[: self._hard],
            u_ref=u_ref,
            low=decision.part("low") - u_ref,
            high=decision.part("high") - u_ref,
            limits=self._limits,
        )
        known = decision.part("u_plus") - u_ref
        kept = program.kept(known)
        if not isfinite(kept):
            return known, Distance(lower=self.floor, upper=self.reach)
        if kept >= self.reach:
            return known, Distance(lower=self.reach, upper=self.reach)
        known, lower, upper = self._by_one_row(program, known, kept)
        if upper - lower > CLOSED * self.reach:
            known, lower, upper = self._solve(program, known, lower, upper)
        lower = min(lower, self.reach)
        return known, Distance(lower=lower, upper=max(lower, upper))

    def _by_one_row(self, program: _Program, known: Array, lower: float) -> tuple[Array, float, float]:
        """Return the best input so far, and the bounds, with what the row proves that can be kept least."""
        corners = np.where(program.G > 0.0, program.high, program.low)
        most = np.add.reduce(program.G * corners, axis=1) - program.d
        row = int(most.argmin())
        corner = program.admissible(corners[row], known)
        if (kept := program.kept(corner)) > lower:
            known, lower = corner, kept
        return known, lower, min(self.reach, float(most[row]))

    def _solve(self, program: _Program, known: Array, lower: float, upper: float) -> tuple[Array, float, float]:
        """Return a better input and better bounds than those so far."""
        self._write(program)
        for _ in range(ATTEMPTS):
            answer = self._ask()
            if answer is None:
                break
            w, weights = answer
            pull, most = self._proof(program, weights)
            touching = _touching(program, w, pull)
            for candidate in (w, *(touch.input(w, program.u_ref) for touch in touching)):
                admissible = program.admissible(candidate, known)
                if (kept := program.kept(admissible)) > lower:
                    known, lower = admissible, kept
            upper = min(upper, most)
            if upper - lower <= CLOSED * self.reach:
                break
            self._refine(program, known, lower, touching)
        return known, lower, upper

    def _write(self, program: _Program) -> None:
        m, scale = self._m, 1 / self.reach
        self._rows[: self._hard, :m] = program.G
        self._above[:m], self._below[:m] = program.high * scale, program.low * scale
        self._bounds[: self._hard] = program.d * scale
        self._rows[self._planes :], self._bounds[self._planes :] = 0.0, -_FAR
        for place, half_space in enumerate(program.limits.half_spaces, start=self._hard):
            beyond = inner(np.array(half_space.weights), program.u_ref) - half_space.bound
            self._bounds[place] = beyond * scale
        self._used = self._planes
        self._linear[:m], self._linear[m] = 0.0, -1 / ETA

    def _ask(self) -> tuple[Array, Array] | None:
        """Return w and the weights of rows and tangents, or ``None`` where the solver fails."""
        self._A[:] = self._rows  # the solver may scale its rows in place
        self._model.update(A=self._A, f=self._linear, bupper=self._above, blower=self._below, sense=self._cold)
        x, _, flag, info = self._model.solve()
        if flag != _SOLVED:
            return None
        weights = np.negative(info["lam"][self._m + 1 :], dtype=np.float64)
        return self.reach * np.array(x[:-1], dtype=np.float64), np.maximum(weights, 0.0)

    def _proof(self, program: _Program, weights: Array) -> tuple[Array, float]:
        """Return Σμᵢgᵢ and the upper bound that the weights prove."""
        hard, used = self._hard, self._used
        total = float(np.add.reduce(weights[:hard]))
        if not total > 0.0:
            return np.zeros(self._m), inf
        mu = weights / total
        pull = product(mu[:hard], program.G)
        most = -inner(mu[:hard], program.d)
        if program.limits.has_only_axes:
            return pull, most + program.most(pull)
        rest = pull + product(mu[hard:used], self._rows[hard:used, :-1])
        past = inner(mu[hard:used], self._bounds[hard:used]) * self.reach
        return pull, most + min(program.most(rest) - past, program.most_in_balls(pull))

    def _refine(self, program: _Program, known: Array, lower: float, touching: list[_Touch]) -> None:
        """Go on from the best input so far, with the norms' tangents where they were touched."""
        m, scale = self._m, 1 / self.reach
        self._linear[:m], self._linear[m] = known * -scale, -lower * scale - 1 / ETA
        for touch in touching:
            axes = list(touch.norm.axes)
            self._rows[self._used, axes] = -touch.unit
            self._bounds[self._used] = (inner(touch.unit, program.u_ref[axes]) - touch.norm.bound) * scale
            self._used += 1


def _touching(program: _Program, w: Array, pull: Array) -> list[_Touch]:
    """Return where norms may bind: the best input is near the answer or where the pull ends."""
    found = []
    for norm in program.limits.norms:
        for u in (program.u_ref + w, pull):
            part = u[list(norm.axes)]
            if size := length(part):
                found.append(_Touch(norm, part / size))
    return found
