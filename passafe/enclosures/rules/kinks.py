"""Balls of functions with kinks, and of the comparisons and choices that their derivatives are made of."""

from collections.abc import Callable, Mapping
from functools import reduce
from typing import Final

import casadi as ca

from passafe.enclosures.rules.ball import Ball, within_range

MIDDLE_ROUNDING: Final = 1e-15
"""Rounding of a middle, relative to the radius: more than the smaller end where the ends are of different sizes."""


def magnitude(a: Ball) -> Ball:
    """Return the ball of |a|, from 0 where a can be 0."""
    size = ca.fabs(a.centre)
    half = (size + a.radius) / 2
    return Ball(ca.fmax(size, half), ca.fmin(a.radius, half))


def minimum(a: Ball, b: Ball) -> Ball:
    """Return the ball of min(a, b)."""
    return _extreme(ca.fmin, a, b)


def maximum(a: Ball, b: Ball) -> Ball:
    """Return the ball of max(a, b)."""
    return _extreme(ca.fmax, a, b)


def _extreme(function: Callable[[ca.SX, ca.SX], ca.SX], a: Ball, b: Ball) -> Ball:
    lower = function(a.centre - a.radius, b.centre - b.radius)
    upper = function(a.centre + a.radius, b.centre + b.radius)
    return Ball(_middle(lower, upper), _half(lower, upper), (*within_range(a), *within_range(b)))


def sign(a: Ball) -> Ball:
    """Return the ball of sign a: all from −1 to 1 where a can be 0."""
    if a.radius.is_zero():
        return Ball(ca.sign(a.centre), a.radius, within_range(a))
    open_ = ca.fabs(a.centre) <= a.radius
    return Ball(ca.if_else(open_, 0, ca.sign(a.centre)), open_, within_range(a))


def signed_like(a: Ball, b: Ball) -> Ball:
    """Return the ball of |a| with b's sign: all from −|a| to |a| where b can be 0."""
    apart = ca.fabs(b.centre) > b.radius
    size = magnitude(a)
    centre = ca.if_else(apart, ca.copysign(size.centre, b.centre), 0)
    return Ball(centre, ca.if_else(apart, size.radius, size.centre + size.radius), within_range(b))


def step(a: Ball) -> Ball:
    """Return the present step, a point: only steps that cancel stand in a design that was not refused."""
    return Ball(ca.floor(a.centre), ca.SX(0), within_range(a))


def _compare(function: Callable[[ca.SX, ca.SX], ca.SX]) -> Callable[[Ball, Ball], Ball]:
    """Return a truth value, 0 or 1; where it may be either, all from 0 to 1."""

    def compared(a: Ball, b: Ball) -> Ball:
        conditions = (*within_range(a), *within_range(b))
        reach = a.radius + b.radius
        if reach.is_zero():
            return Ball(function(a.centre, b.centre), reach, conditions)
        open_ = ca.fabs(a.centre - b.centre) <= reach
        return Ball(ca.if_else(open_, 0.5, function(a.centre, b.centre)), open_ / 2, conditions)

    return compared


def share(chosen: Ball, other: Ball) -> Ball:
    """Return the ball of chosen/(chosen + other) of two truth values of which at least one is 1: ½ if both are."""
    return Ball(chosen.centre / (chosen.centre + other.centre), chosen.radius)


def negation(a: Ball) -> Ball:
    """Return the ball of "not a"."""
    surely, maybe = _truth(a)
    return _choice(ca.logic_not(maybe), ca.logic_not(surely))


def both(a: Ball, b: Ball) -> Ball:
    """Return the ball of "a and b"."""
    return _choice(*(ca.logic_and(one, other) for one, other in zip(_truth(a), _truth(b), strict=True)))


def either(a: Ball, b: Ball) -> Ball:
    """Return the ball of "a or b"."""
    return _choice(*(ca.logic_or(one, other) for one, other in zip(_truth(a), _truth(b), strict=True)))


def where(condition: Ball, a: Ball) -> Ball:
    """Return the ball of a where the condition holds, else of 0; what a asks for is asked where it may hold."""
    surely, maybe = _truth(condition)
    lower, upper = a.centre - a.radius, a.centre + a.radius
    least, most = ca.fmin(lower, 0), ca.fmax(upper, 0)
    centre = ca.if_else(surely, a.centre, ca.if_else(maybe, _middle(least, most), 0))
    radius = ca.if_else(surely, a.radius, ca.if_else(maybe, _half(least, most), 0))
    if not a.conditions:
        return Ball(centre, radius, condition.conditions)
    asked = ca.if_else(maybe, reduce(ca.logic_and, a.conditions), 1)
    return Ball(centre, radius, (*condition.conditions, asked))


def _truth(a: Ball) -> tuple[ca.SX, ca.SX]:
    """Return whether a number is certainly not zero, and whether it may be not zero."""
    return ca.fabs(a.centre) > a.radius, ca.fabs(a.centre) + a.radius > 0


def _choice(surely: ca.SX, maybe: ca.SX) -> Ball:
    return Ball((surely + maybe) / 2, (maybe - surely) / 2)


def _middle(lower: ca.SX, upper: ca.SX) -> ca.SX:
    return (lower + upper) / 2


def _half(lower: ca.SX, upper: ca.SX) -> ca.SX:
    """Return the radius from ``lower`` to ``upper``, and what the middle of a large ball may be rounded by."""
    return (upper - lower) / 2 * (1 + MIDDLE_ROUNDING)


RULES: Final[Mapping[int, Callable[..., Ball]]] = {
    ca.OP_FABS: magnitude,
    ca.OP_FMIN: minimum,
    ca.OP_FMAX: maximum,
    ca.OP_SIGN: sign,
    ca.OP_FLOOR: step,
    ca.OP_COPYSIGN: signed_like,
    ca.OP_LT: _compare(ca.lt),
    ca.OP_LE: _compare(ca.le),
    ca.OP_NOT: negation,
    ca.OP_AND: both,
    ca.OP_OR: either,
    ca.OP_IF_ELSE_ZERO: where,
}
