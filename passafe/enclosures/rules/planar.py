"""Balls of functions of a point of the plane: its distance from the origin and its direction."""

from collections.abc import Callable, Mapping
from typing import Final

import casadi as ca

from passafe.enclosures.rules.ball import Ball, within_range


def distance(a: Ball, b: Ball) -> Ball:
    """Return the ball of hypot(a, b), which changes by no more than the point moves."""
    return Ball(ca.hypot(a.centre, b.centre), ca.hypot(a.radius, b.radius))


def direction(y: Ball, x: Ball) -> Ball:
    """Return the ball of atan2(y, x), where neither the origin nor the cut along the negative axis is within reach.

    Seen from the origin, a disk of radius d at distance D covers asin(d/D) to either side.
    """
    away, reach = ca.hypot(y.centre, x.centre), ca.hypot(y.radius, x.radius)
    apart = ca.logic_and(away > reach, ca.logic_or(x.centre > x.radius, ca.fabs(y.centre) > y.radius))
    share = ca.if_else(apart, reach, 0) / ca.if_else(apart, away, 1)
    conditions = (apart, *within_range(y), *within_range(x))
    return Ball(ca.atan2(y.centre, x.centre), ca.asin(share), conditions)


RULES: Final[Mapping[int, Callable[..., Ball]]] = {ca.OP_HYPOT: distance, ca.OP_ATAN2: direction}
