"""Balls of sums, products, squares and quotients."""

from collections.abc import Callable, Mapping
from typing import Final

import casadi as ca

from passafe.enclosures.rules.ball import Ball, within_range


def add(a: Ball, b: Ball) -> Ball:
    """Return the ball of a + b."""
    return Ball(a.centre + b.centre, a.radius + b.radius)


def subtract(a: Ball, b: Ball) -> Ball:
    """Return the ball of a − b."""
    return Ball(a.centre - b.centre, a.radius + b.radius)


def negate(a: Ball) -> Ball:
    """Return the ball of −a."""
    return Ball(-a.centre, a.radius)


def twice(a: Ball) -> Ball:
    """Return the ball of 2a."""
    return Ball(2 * a.centre, 2 * a.radius)


def multiply(a: Ball, b: Ball) -> Ball:
    """Return the ball of a·b."""
    radius = ca.fabs(a.centre) * b.radius + a.radius * ca.fabs(b.centre) + a.radius * b.radius
    return Ball(a.centre * b.centre, radius)


def square(a: Ball) -> Ball:
    """Return the ball of a²: never negative, so from 0 where a can be 0, else from (|a| − r)² to (|a| + r)²."""
    size = ca.fabs(a.centre)
    over = ca.fmax(a.radius - size, 0)
    beyond = over * over / 2
    return Ball(a.centre * a.centre + a.radius * a.radius - beyond, 2 * size * a.radius + beyond)


def invert(a: Ball) -> Ball:
    """Return the ball of 1/a, whose ends are 1/(a − r) and 1/(a + r), where zero is out of reach."""
    if a.radius.is_zero():
        return Ball(1 / a.centre, a.radius, within_range(a))
    size = ca.fabs(a.centre)
    apart = size > a.radius
    share = ca.if_else(apart, a.radius / ca.if_else(apart, size, 1), 0)
    centre = 1 / ca.if_else(apart, a.centre, 1) / ((1 - share) * (1 + share))
    return Ball(centre, share * ca.fabs(centre), (apart, *within_range(a)))


def divide(a: Ball, b: Ball) -> Ball:
    """Return the ball of a/b where zero is out of b's reach."""
    if b.radius.is_zero():
        return Ball(a.centre / b.centre, a.radius / ca.fabs(b.centre), within_range(b))
    inverse = invert(b)
    return multiply(a, inverse)._replace(conditions=inverse.conditions)


RULES: Final[Mapping[int, Callable[..., Ball]]] = {
    ca.OP_ADD: add,
    ca.OP_SUB: subtract,
    ca.OP_NEG: negate,
    ca.OP_TWICE: twice,
    ca.OP_MUL: multiply,
    ca.OP_SQ: square,
    ca.OP_INV: invert,
    ca.OP_DIV: divide,
}
