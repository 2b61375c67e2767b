"""Bounds of what rows leave out, for all members of a family of plants (``docs/theory.md``, section 13).

Let q = ṗ of the model, Q(τ) its value along the true plant, which begins anywhere in a box around x, and W the most
that disturbance and input error take from ṗ. Then ṗ ≥ Q − W, Q̇ = −λQ + b along the true plant, and as between samples

    p(τ) ≥ p(0) + φ₁(τ)(Q(0) − (T/φ₁(T))W + (φ₂/φ₁)(b(0) − V)),

so that a row is kept by every member if it is kept with ``uncertainty`` to spare, in both of its conditions.
"""

from typing import NamedTuple

import casadi as ca

from passafe.enclosures.angle_cuts import apart_from_cuts
from passafe.enclosures.enclosure import enclose
from passafe.enclosures.jump_bound import jump_bound
from passafe.enclosures.reachable_tube import Tube
from passafe.errors import DesignError
from passafe.margins.intersample_margin import HeldRow
from passafe.margins.plant_family import PlantFamily


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
    family: PlantFamily,
    row: HeldRow,
    tube: Tube,
    held_s: float,
    x_radius: ca.SX,
    input_radius: ca.SX,
    *,
    at_ends: bool = True,
) -> MemberBound:
    """Return the bounds of one row.

    Args:
        family: The plants.
        row: Its conditions, with the coordinates' symbols in them.
        tube: Of all members around where they begin, for the same inputs.
        held_s: T, how long the input is held at most, s.
        x_radius: Error of x, expression, shape (n, 1).
        input_radius: By how much each axis of the held input may differ from u, expression, shape (m, 1).
        at_ends: Whether there is a row at each end of what multiplies the input; else the bound covers that, too.

    Raises:
        DesignError: The bounds of the row's derivatives are given, or it has an operation without an enclosure.
    """
    if row.change is not None:
        raise DesignError("uncertainty", "a row with derivative_bounds", "rows whose derivatives are enclosed")
    system, ends = family.system, family.ends(row.q) if at_ends else ()
    between = [each for each in family.coordinates if each not in ends]
    rest = ca.vertcat(ca.SX(0, 1), *(each.symbol for each in between))
    rest_radius = ca.SX(ca.DM([each.radius for each in between]))
    held = ca.vertcat(system.u, family.symbols)
    held_radius = ca.vertcat(input_radius + family.input_error, family.radii)
    moving, reach = ca.vertcat(system.x, system.t), ca.vertcat(tube.radius + x_radius, held_s)
    box = _Box(ca.vertcat(moving, held), ca.vertcat(reach, held_radius))
    q, p = box.enclosed(ca.gradient(row.q, system.x)), box.enclosed(ca.gradient(row.p, system.x))
    bend = box.enclosed(ca.gradient(row.bend, moving)).most

    pushed = ca.dot(p.most, family.disturbance) + box.most(ca.gradient(row.q, system.u), ca.SX(family.input_error))
    less = held_s / row.usable_s * pushed + row.ratio_s * ca.dot(q.most, _push(family, box))
    less += ca.dot(bend[: system.n] + _slope_of_value(row, q, p, box, system.x).most, x_radius)
    less += box.most(ca.gradient(row.q, rest), rest_radius) + box.most(ca.gradient(row.bend, rest), rest_radius)
    for each in ends:
        less += box.most(ca.jacobian(ca.gradient(row.bend, each.symbol), each.symbol), ca.SX(each.radius**2 / 2))

    jumps, jumps_known = jump_bound(row.bend, moving, reach, held, held_radius)
    known = tube.known * box.known * jumps_known * apart_from_cuts(row.continuous, moving, reach)
    fading = ca.fmin(row.p + ca.dot(p.most, x_radius), 0) / row.usable_s
    deviation = ca.if_else(known, ca.dot(bend, ca.vertcat(tube.radius, held_s)) + jumps, 0) + fading
    found = ca.substitute([deviation, ca.if_else(known, less, 0), known], [family.symbols], [family.centres])
    return MemberBound(*found)


class _Slope(NamedTuple):
    """Enclosure of a gradient."""

    centre: ca.SX
    radius: ca.SX

    @property
    def most(self) -> ca.SX:
        """Largest magnitudes."""
        return ca.fabs(self.centre) + self.radius


class _Box:
    """States, times, inputs and parameters that a row may meet.

    One box for all, also for what is asked at the beginning alone: then most enclosures are evaluated once.
    """

    def __init__(self, symbols: ca.SX, radius: ca.SX) -> None:
        """Begin with nothing enclosed."""
        self._symbols, self._radius, self.known = symbols, radius, ca.SX(1)

    def enclosed(self, slope: ca.SX) -> _Slope:
        """Return the enclosure of a gradient over the box."""
        ball = enclose(ca.densify(slope), self._symbols, self._radius)
        self.known = self.known * ball.known
        return _Slope(ball.centre, ball.radius)

    def most(self, slope: ca.SX, reach: ca.SX) -> ca.SX:
        """Return Σ sup|slopeᵢ|·reachᵢ."""
        counts = [i for i in range(reach.numel()) if not reach[i].is_zero() and not slope[i].is_zero()]
        return ca.dot(self.enclosed(slope[counts]).most, reach[counts]) if counts else ca.SX(0)


def _slope_of_value(row: HeldRow, q: _Slope, p: _Slope, box: _Box, x: ca.SX) -> _Slope:
    """Return the gradient of q + γ̃(p) in x: of the two that are known, where γ̃ is linear."""
    if row.gain is None:
        return box.enclosed(ca.gradient(row.value, x))
    return _Slope(q.centre + row.gain * p.centre, q.radius + row.gain * p.radius)


def _push(family: PlantFamily, box: _Box) -> ca.SX:
    """Return the bound of all that acts on each state's rate besides the model, shape (n, 1)."""
    push = ca.SX(family.disturbance)
    if not float(ca.norm_inf(family.input_error)):
        return push
    effect = ca.jacobian(family.system.general_f, family.system.u)
    return push + ca.reshape(box.enclosed(ca.vec(effect)).most, effect.shape) @ family.input_error
