"""Bounds of what rows leave out, for all members of a family of plants (``docs/theory.md``, section 9a).

Let q = ṗ of the model, Q(τ) its value along the true plant, which begins anywhere in a box around x, and W the most
that disturbance and input error take from ṗ. Then ṗ ≥ Q − W, Q̇ = −λQ + b along the true plant, and as between samples

    p(τ) ≥ p(0) + φ₁(τ)(Q(0) − (T/φ₁(T))W + (φ₂/φ₁)(b(0) − V)),

so that a row is kept by every member if it is kept with ``uncertainty`` to spare, in both of its conditions.
"""

from typing import NamedTuple

import casadi as ca

from passafe.enclosure import Enclosure, enclose
from passafe.errors import DesignError
from passafe.intersample_margin import HeldRow
from passafe.jump_bound import jump_bound
from passafe.plant_family import PlantFamily
from passafe.reachable_tube import Tube


class MemberBound(NamedTuple):
    """Bounds for all members, expressions of x, u and t, in the units of q.

    Attributes:
        deviation: How much ratio·b may change while the input is held.
        uncertainty: How much less a member's row may be than that of the member in the middle, or at an end.
        known: 1 where both are proven, else 0.
    """

    deviation: ca.SX
    uncertainty: ca.SX
    known: ca.SX


def member_bound(
    family: PlantFamily, row: HeldRow, tube: Tube, held_s: float, x_radius: ca.SX, input_radius: ca.SX
) -> MemberBound:
    """Return the bounds of one row.

    Args:
        family: The plants.
        row: Its conditions, with the coordinates' symbols in them.
        tube: Of all members around where they begin, for the same inputs.
        held_s: T, how long the input is held at most, s.
        x_radius: Error of x, expression, shape (n, 1).
        input_radius: By how much each axis of the held input may differ from u, expression, shape (m, 1).

    Raises:
        DesignError: The bounds of the row's derivatives are given, or it has an operation without an enclosure.
    """
    if row.change is not None:
        raise DesignError("uncertainty", "a row with derivative_bounds", "rows whose derivatives are enclosed")
    system = family.system
    ends = family.ends(row.q)
    between = [each for each in family.coordinates if each not in ends]
    rest = ca.vertcat(ca.SX(0, 1), *(each.symbol for each in between))
    rest_radius = ca.SX(ca.DM([each.radius for each in between]))
    held = ca.vertcat(system.u, family.symbols)
    held_radius = ca.vertcat(input_radius + family.input_error, family.radii)
    first = ca.vertcat(system.x, held), ca.vertcat(x_radius, held_radius)
    along = ca.vertcat(system.x, system.t, held), ca.vertcat(tube.radius + x_radius, held_s, held_radius)
    known = tube.known

    def most(slope: ca.SX, reach: ca.SX, box: tuple[ca.SX, ca.SX]) -> ca.SX:
        nonlocal known
        size, is_known = _most(slope, reach, box)
        known = known * is_known
        return size

    moved, moved_radius = ca.vertcat(system.x, rest), ca.vertcat(x_radius, rest_radius)
    less = most(ca.gradient(row.value, moved), moved_radius, first)
    pushed = most(ca.gradient(row.p, system.x), ca.SX(family.disturbance), along)
    pushed += most(ca.gradient(row.q, system.u), ca.SX(family.input_error), along)
    less += held_s / row.usable_s * pushed
    slope = _enclosed(ca.gradient(row.bend, ca.vertcat(system.x, system.t)), along)
    steepest = ca.fabs(slope.centre) + slope.radius
    less += ca.dot(steepest[: system.n], x_radius)
    less += most(ca.gradient(row.bend, rest), rest_radius, first)
    less += row.ratio_s * most(ca.gradient(row.q, system.x), _push(family, along), along)
    for each in ends:
        less += most(ca.jacobian(ca.gradient(row.bend, each.symbol), each.symbol), ca.SX(each.radius**2 / 2), first)
    reach = ca.vertcat(tube.radius, held_s)
    jumps, jumps_known = jump_bound(
        row.bend, ca.vertcat(system.x, system.t), ca.vertcat(tube.radius + x_radius, held_s), held, held_radius
    )
    fading = ca.fmin(row.p + most(ca.gradient(row.p, system.x), x_radius, first), 0) / row.usable_s
    known = known * slope.known * jumps_known
    deviation = ca.if_else(known, ca.dot(steepest, reach) + jumps, 0) + fading
    found = ca.substitute([deviation, ca.if_else(known, less, 0), known], [family.symbols], [family.centres])
    return MemberBound(*found)


def _push(family: PlantFamily, box: tuple[ca.SX, ca.SX]) -> ca.SX:
    """Return the bound of all that acts on each state's rate besides the model, shape (n, 1)."""
    push = ca.SX(family.disturbance)
    if not family.input_error.nnz() or not ca.norm_inf(family.input_error):
        return push
    effect = ca.jacobian(family.system.general_f, family.system.u)
    ball = enclose(ca.vec(ca.densify(effect)), *box)
    return push + ca.reshape(ca.fabs(ball.centre) + ball.radius, effect.shape) @ family.input_error


def _most(slope: ca.SX, reach: ca.SX, box: tuple[ca.SX, ca.SX]) -> tuple[ca.SX, ca.SX]:
    """Return Σ sup|slopeᵢ|·reachᵢ over a box, and whether it is known."""
    counts = [i for i in range(reach.numel()) if not reach[i].is_zero() and not slope[i].is_zero()]
    if not counts:
        return ca.SX(0), ca.SX(1)
    ball = _enclosed(slope[counts], box)
    return ca.dot(ca.fabs(ball.centre) + ball.radius, reach[counts]), ball.known


def _enclosed(slope: ca.SX, box: tuple[ca.SX, ca.SX]) -> Enclosure:
    return enclose(ca.densify(slope), *box)
