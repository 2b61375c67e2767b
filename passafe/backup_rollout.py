"""The course of the robot under an input that is held first and the backup law afterwards, with what it keeps.

The backup law is the design's fail-safe, within the limits, sent anew every period. Its course is rolled out with the
sampled plant's own step; between samples h is bounded from below by

    h(τ) ≥ min(h(0), h(T)) − T²/8·sup|ḧ|   for 0 ≤ τ ≤ T,

the error of linear interpolation, with ḧ enclosed over the tube that is reachable within the period. So what is found
to be kept is kept between samples too, up to the integration error that the step estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from math import inf
from typing import Final

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign
from passafe.enclosure import enclose
from passafe.reachable_tube import reachable_tube
from passafe.sampled_plant import held_flow
from passafe.workspace import Array

CHUNK: Final = 64
"""Periods that one call rolls out."""

LONGEST: Final = 32
"""Calls after which a rollout ends where the robot has not come to rest."""

AT_REST: Final = 1e-9
"""Change of the state over a chunk, relative to 1 + |x|, below which the robot counts as at rest."""

EQUAL: Final = 1e-3
"""Difference of two violations, relative to them, that counts as none."""

ROUNDING: Final = 1e-9
"""Value below zero that counts as zero where two courses are compared."""

LARGEST_ERROR: Final = 1e-6
"""Sum of the estimated integration errors from which on a rollout proves nothing."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Course:
    """Outcome of one rollout.

    Attributes:
        kept_periods: Periods from the first on in which every barrier is kept; infinite where it is to the end.
        lowest: Smallest lower bound of all h.
        is_proven: Whether the bounds between samples and the integration are known all along.
        comes_to_rest: Whether the state settled before the rollout ended.
    """

    kept_periods: float
    lowest: float
    is_proven: bool
    comes_to_rest: bool

    @property
    def is_safe(self) -> bool:
        """True if every barrier is proven to be kept until the robot rests."""
        return self.is_proven and self.comes_to_rest and self.lowest >= 0.0

    def is_no_worse_than(self, other: "Course") -> bool:
        """Return whether no barrier is lost earlier than on another course, nor by more than rounding and ``EQUAL``."""
        deepest = min(other.lowest, 0.0) * (1 + EQUAL) - ROUNDING
        return self.kept_periods >= other.kept_periods and self.lowest >= deepest

    def or_worse(self, other: "Course") -> "Course":
        """Return what is certain of a course that may be this one or another."""
        return Course(
            kept_periods=min(self.kept_periods, other.kept_periods),
            lowest=min(self.lowest, other.lowest),
            is_proven=self.is_proven and other.is_proven,
            comes_to_rest=self.comes_to_rest and other.comes_to_rest,
        )


KEPT: Final = Course(kept_periods=inf, lowest=0.0, is_proven=True, comes_to_rest=True)
"""A course on which every barrier is kept."""


class BackupRollout:
    """Rolls the backup law out from any state."""

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain]) -> None:
        """Derive the step.

        Args:
            design: The filter's.
            chains: Chains of the barriers that are to be kept.
        """
        system = design.system
        self._n, self._m = system.n, system.m
        low, high = design.limits.interval(system.u, design.dt_s)
        law = design.limits.clip(design.fail_safe, system.u, low, high)
        self._law = ca.Function("law", [system.x, system.u], [law])
        x_next, _, error = held_flow(system, design.dt_s)
        bound, known = _lower_bounds(design, chains, x_next)
        end = ca.vertcat(x_next, system.t + design.dt_s)
        seen = ca.vertcat(bound, error, known)
        hold = ca.Function("hold", [ca.vertcat(system.x, system.t), system.u], [end, ca.densify(seen)])
        state = ca.vertcat(system.x, system.t, system.u)
        u = self._law(system.x, system.u)
        step = ca.Function(
            "step", [state], [ca.vertcat(*hold(state[: -self._m], u)[:1], u), hold(state[: -self._m], u)[1]]
        )
        self._hold, self._roll = hold, step.mapaccum("roll", CHUNK)

    def course(self, x: Array, t_s: float, u: Array, held_periods: int, than: Course | None = None) -> Course:
        """Return the course under an input that is held for some periods, and the backup law from then on.

        It ends early where it has become worse than another one.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: The input, shape (m,); the one before where nothing is held.
            held_periods: Number of periods, 0 or more.
            than: The other one; ``None`` to follow the course to its end.
        """
        state = np.array([*x, t_s])
        seen = []
        for _ in range(held_periods):
            after, observed = self._hold(state, u)
            state = after.full().ravel()
            seen.append(observed.full())
        full, rests = np.concatenate((state, u)), False
        for _ in range(LONGEST):
            before = full
            after, observed = self._roll(full)
            full = after.full()[:, -1]
            seen.append(observed.full())
            if than is not None and not _outcome(np.hstack(seen), rests=False).is_no_worse_than(than):
                break
            change = np.abs(full[: self._n] - before[: self._n])
            if not np.isfinite(full).all() or (change <= AT_REST * (1 + np.abs(full[: self._n]))).all():
                rests = bool(np.isfinite(full).all())
                break
        return _outcome(np.hstack(seen), rests=rests)


def _lower_bounds(design: FilterDesign, chains: Sequence[BarrierChain], x_next: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the lower bound of the smallest h over a period, scalar, and 1 where all bounds are known, else 0."""
    system, dt_s = design.system, design.dt_s
    tube = reachable_tube(system, dt_s, ca.SX.zeros(system.m))
    moving, reach = ca.vertcat(system.x, system.t), ca.vertcat(tube.radius, dt_s)
    lowest, known = ca.SX(inf), tube.known
    for chain in chains:
        bounds = []
        for h in (branch.psi[0] for branch in chain.branches):
            ball = enclose(system.rate(system.rate(h)), moving, reach)
            sag = dt_s**2 / 8 * (ca.fabs(ball.centre) + ball.radius)
            end = ca.substitute(h, moving, ca.vertcat(x_next, system.t + dt_s))
            bounds.append(ca.fmin(h, end) - ca.if_else(tube.known * ball.known, sag, 0))
            known *= ball.known
        lowest = ca.fmin(lowest, reduce(ca.fmax, bounds))
    return lowest, known


def _outcome(seen: Array, *, rests: bool) -> Course:
    lowest, errors, known = seen
    lost = np.flatnonzero(~(lowest >= 0.0))
    return Course(
        kept_periods=float(lost[0]) if len(lost) else inf,
        lowest=float(np.nanmin(lowest, initial=inf)) if not np.isnan(lowest).any() else -inf,
        is_proven=bool((known > 0).all() and np.nansum(errors) <= LARGEST_ERROR and np.isfinite(errors).all()),
        comes_to_rest=rests,
    )
