"""The course of the robot under an input that is held first and the backup law afterwards, with what it keeps.

The backup law is the design's fail-safe, within the limits, sent anew every period. Its course is rolled out with the
sampled plant's own step; between samples h is bounded from below by

    h(τ) ≥ min(h(0), h(T)) − T²/8·sup|ḧ|   for 0 ≤ τ ≤ T,

the error of linear interpolation, with ḧ enclosed over the tube that is reachable within the period. So what is found
to be kept is kept between samples too, up to the integration error that the step estimates.

Courses are compared by an estimate that is sharper than the bound, and known everywhere: the least value of the cubic
through h and ḣ at both ends of a period. By the bound, standing still would seem better than to drive away from a wall.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from math import inf, isfinite
from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.courses.course import CHUNK, Course
from passafe.courses.course_record import ChunkSummary, CourseRecord
from passafe.courses.settling import Settling
from passafe.design import FilterDesign
from passafe.enclosures.angle_cuts import apart_from_cuts
from passafe.enclosures.enclosure import enclose
from passafe.enclosures.reachable_tube import reachable_tube
from passafe.numerics.workspace import Array, BlockLayout, Compiler, Workspace, dense_function, interpreted
from passafe.sampled_plant import held_flow

LONGEST: Final = 2048
"""Periods after which a rollout ends where the robot has not come to rest."""

AT_REST: Final = 1e-9
"""Change of the state over a chunk, relative to 1 + |x|, below which the robot counts as at rest."""


class BackupRollout:
    """Rolls the backup law out from any state."""

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain], compiler: Compiler = interpreted) -> None:
        """Derive the step.

        Args:
            design: The filter's.
            chains: Chains of the barriers that are to be kept.
            compiler: Compiles what takes the time.
        """
        self._n = design.system.n
        step, law = _step(design, chains)
        self._settling = Settling(design, chains, step, law)
        roll = compiler(_chunk(step))
        sizes: dict[str, int | tuple[int, ...]] = {"state": roll.size1_in(0), "held": CHUNK, "after": roll.size1_in(0)}
        sizes |= {"seen": (5, CHUNK), **dict.fromkeys(ChunkSummary.names(), 1)}
        space = Workspace(BlockLayout.of(sizes))
        self._state, self._held = space.part("state"), space.part("held")
        self._seen, self._read_after = space.view("seen"), space.reader("after")
        self._read_summary = space.scalar_reader(ChunkSummary[float])
        self._roll = space.bind(roll, ("state", "held"), ("after", "seen", *ChunkSummary.names()))
        self._space = space  # holds what the call above writes to

    def course(
        self,
        x: Array,
        t_s: float,
        u: Array,
        held_periods: int,
        than: Course | None = None,
        until: int = LONGEST,
        *,
        to_prove: bool = False,
        law_held: int = 1,
    ) -> Course:
        """Return the course under an input that is held for some periods, and the backup law from then on.

        It ends early where it has become worse than another one, or cannot be proven to be safe any more.

        Args:
            x: State, shape (n,).
            t_s: Plant time, s.
            u: The input, shape (m,); the one before where nothing is held.
            held_periods: Number of periods, 0 or more.
            than: The other one; ``None`` to follow the course to its end.
            until: Number of periods after which the course ends, but not before ``CHUNK`` of the backup law. Courses
                that do not come to rest are compared over the same time.
            to_prove: Whether the course is of use only if it is proven to be safe.
            law_held: Number of periods for which each input of the law is held: more than one where those between
                are lost. Once the state is known to settle, none is.
        """
        state, record, rests = self._state, CourseRecord(), False
        state[:] = before = (*x, t_s, *u)
        look = held_periods
        for begins in range(0, max(until, held_periods + CHUNK), CHUNK):
            self._held[:] = _held(begins - held_periods, law_held)
            self._roll()
            state[:] = now = self._read_after()
            is_worse = record.add(self._seen, self._read_summary())
            if is_worse and than is not None and not record.course(rests=False).is_no_worse_than(than):
                break
            is_kept = record.is_kept
            if (to_prove and not is_kept) or not isfinite(sum(now)):
                break
            is_still = begins >= held_periods and _is_still(before[: self._n], now)
            rests = is_still and self._settling.is_static
            if self._settling.may_tell and (is_still or begins >= look) and is_kept:
                look = begins + max(CHUNK, (begins - held_periods) // 2)
                may_rest = self._settling.may_keep(state)
                rests = (may_rest and record.settles(self._settling.lowest(state))) or rests
            if rests or is_still:
                break
            before = now
        return record.course(rests=rests)


def _held(since: int, law_held: int) -> Array | float:
    """Return in which periods of a chunk the input is held, 1, or the law's is sent, 0.

    Args:
        since: First period, counted from the first input of the law.
        law_held: Number of periods for which each input of the law is held.
    """
    if since >= 0 and law_held == 1:
        return 0.0
    periods = np.arange(since, since + CHUNK)
    return np.asarray((periods < 0) | (periods % law_held != 0), dtype=float)


def _is_still(before: tuple[float, ...], now: tuple[float, ...]) -> bool:
    """Return whether a state has not changed but by ``AT_REST``."""
    return all(abs(after - was) <= AT_REST * (1 + abs(after)) for was, after in zip(before, now, strict=False))


def _step(design: FilterDesign, chains: Sequence[BarrierChain]) -> tuple[ca.Function, ca.SX]:
    """Return one period, from (x, t, u before) and whether u is held to the next and what is seen; and the law."""
    system = design.system
    low, high = design.limits.interval(system.u, design.dt_s)
    law = design.limits.clip(design.fail_safe, system.u, low, high)
    # Without the energy, whose error is in other units and no matter here.
    x_next, _, error = held_flow(
        replace(system, y=ca.SX.zeros(system.m), port_y=ca.SX(0, 0), port_u=ca.SX(0, 0)), design.dt_s
    )
    least = _least_h(design, chains, x_next)
    slopes = (ca.norm_2(ca.gradient(b.psi[0], system.x)) for chain in chains for b in chain.branches)
    slope = reduce(ca.fmax, slopes, ca.SX(0))
    seen = ca.densify(ca.vertcat(least.estimate, least.bound, slope, error, least.known))
    end = ca.densify(ca.vertcat(x_next, system.t + design.dt_s, system.u))
    period = ca.Function("period", [ca.vertcat(system.x, system.t), system.u], [end, seen])
    state, held = ca.vertcat(system.x, system.t, system.u), ca.SX.sym("held")
    after, observed = period(state[: -system.m], ca.if_else(held, system.u, law))
    return dense_function("step", [state, held], [after, observed]), law


def _chunk(step: ca.Function) -> ca.Function:
    """Return ``CHUNK`` periods at once: from a state and whether the input is held, to the last and what is seen."""
    state, held = ca.MX.sym("state", step.size1_in(0)), ca.MX.sym("held", 1, CHUNK)
    states, seen = step.mapaccum("periods", CHUNK)(state, held)
    estimates, bounds, _, errors, known = ca.vertsplit(seen)
    summary = ChunkSummary(
        lowest=ca.mmin(estimates),
        bound=ca.mmin(bounds),
        error=ca.sum2(errors),
        known=ca.mmin(known),
        total=ca.sum2(ca.sum1(seen)),
    )
    return ca.Function("roll", [state, held], [states[:, -1], seen, *summary.fields().values()])


class _LeastH(NamedTuple):
    """Least h of all barriers over a period.

    Attributes:
        estimate: By the cubic, expression.
        bound: Lower bound, expression; means nothing where it is not known.
        known: 1 where it is, else 0, expression.
    """

    estimate: ca.SX
    bound: ca.SX
    known: ca.SX


def _least_h(design: FilterDesign, chains: Sequence[BarrierChain], x_next: ca.SX) -> _LeastH:
    system, dt_s = design.system, design.dt_s
    tube = reachable_tube(system, dt_s, ca.SX.zeros(system.m))
    moving, reach = ca.vertcat(system.x, system.t), ca.vertcat(tube.radius, dt_s)
    estimate, bound, known = ca.SX(inf), ca.SX(inf), tube.known
    for chain in chains:
        estimates, bounds = [], []
        given = chain.barrier.derivative_bounds
        for h in (branch.psi[0] for branch in chain.branches):
            rate = system.rate(h)
            if given is None:
                ball = enclose(system.rate(rate), moving, reach)
                most, is_known = ca.fabs(ball.centre) + ball.radius, ball.known
            else:
                most, is_known = given.within(system, tube, dt_s, ca.SX.zeros(system.m))[1], ca.SX(1)
            sag = dt_s**2 / 8 * most
            end, end_rate = (ca.substitute(each, moving, ca.vertcat(x_next, system.t + dt_s)) for each in (h, rate))
            estimates.append(least_of_cubic(h, end, dt_s * rate, dt_s * end_rate))
            bounds.append(ca.fmin(h, end) - sag)
            known *= is_known * apart_from_cuts(h, moving, reach)
        estimate, bound = ca.fmin(estimate, reduce(ca.fmax, estimates)), ca.fmin(bound, reduce(ca.fmax, bounds))
    return _LeastH(estimate, bound, known)


def least_of_cubic(begin: ca.SX, end: ca.SX, begin_slope: ca.SX, end_slope: ca.SX) -> ca.SX:
    """Return the least value on [0, 1] of the cubic with given values and slopes at both ends, scalars."""
    a = 3 * (end - begin) - 2 * begin_slope - end_slope
    b = begin_slope + end_slope - 2 * (end - begin)
    # The root of begin_slope + 2as + 3bs² at which the cubic is curved upwards
    below = a + ca.sqrt(ca.fmax(a**2 - 3 * b * begin_slope, 0))
    is_inside = ca.logic_and(begin_slope < 0, below > -begin_slope)
    s = ca.if_else(is_inside, -begin_slope / ca.if_else(is_inside, below, 1), 0)
    return ca.fmin(ca.fmin(begin, end), begin + s * (begin_slope + s * (a + s * b)))
