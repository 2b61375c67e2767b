"""Balls of roots, exponentials, logarithms and powers."""

from collections.abc import Callable, Mapping
from typing import Final

import casadi as ca

from passafe.enclosures.rules.arithmetic import invert, multiply
from passafe.enclosures.rules.ball import Ball, within_range

ROUNDING: Final = 1e-14
"""By how much, relative to its upper end, a ball of sums of squares may reach below zero."""

LARGEST_EXPONENT: Final = 690.0
"""Exponent up to which exponentials count as finite."""


def root(a: Ball) -> Ball:
    """Return the ball of √a, whose ends are those of a's roots, where a cannot be negative."""
    lower, upper = a.centre - a.radius, a.centre + a.radius
    positive = lower >= -ROUNDING * upper
    low, high = ca.sqrt(ca.fmax(lower, 0)), ca.sqrt(ca.fmax(upper, 0))
    middle = ca.sqrt(ca.fmax(a.centre, 0))
    # √a is concave, so it is furthest from √centre at the lower end: r/(√centre + √lower), which does not cancel.
    away = ca.if_else(a.radius > 0, a.radius / ca.if_else(middle + low > 0, middle + low, 1), 0)
    return Ball(middle, ca.fmin(away, high), (positive,))


def exponential(a: Ball) -> Ball:
    """Return the ball of eᵃ."""
    return _grown(a, ca.exp, 0)


def exponential_less_one(a: Ball) -> Ball:
    """Return the ball of eᵃ − 1."""
    return _grown(a, ca.expm1, -1)


def _grown(a: Ball, function: Callable[[ca.SX], ca.SX], offset: float) -> Ball:
    """Return the ball of eᵃ + ``offset``, where that does not overflow."""
    small = a.centre + a.radius < LARGEST_EXPONENT
    centre, radius = ca.if_else(small, a.centre, 0), ca.if_else(small, a.radius, 0)
    value = function(centre)
    near = (value - offset) * ca.expm1(ca.fmin(radius, 1))
    far = ca.exp(centre + radius) - ca.exp(centre)
    return Ball(value, ca.if_else(radius < 1, near, far), (small, *within_range(a)))


def logarithm(a: Ball) -> Ball:
    """Return the ball of log a, where a is positive; furthest from log centre at the lower end, as it is concave."""
    apart = a.centre > a.radius
    centre = ca.if_else(apart, a.centre, 1)
    return Ball(ca.log(centre), -ca.log1p(-ca.if_else(apart, a.radius, 0) / centre), (apart,))


def logarithm_of_one_more(a: Ball) -> Ball:
    """Return the ball of log(1 + a), where that is positive."""
    apart = 1 + a.centre > a.radius
    centre = ca.if_else(apart, a.centre, 0)
    return Ball(ca.log1p(centre), -ca.log1p(-ca.if_else(apart, a.radius, 0) / (1 + centre)), (apart,))


def power(a: Ball, b: Ball) -> Ball:
    """Return the ball of aᵇ: of any a for a whole number b, of positive a otherwise."""
    if b.centre.is_constant():
        return _constant_power(a, float(b.centre))
    log = logarithm(a)
    exponent = multiply(log, b)
    grown = exponential(exponent)
    return grown._replace(conditions=log.conditions + grown.conditions)


def _constant_power(a: Ball, exponent: float) -> Ball:
    """Return the ball of a to a constant: steepest at the end away from zero, or towards it below the power 1."""
    size = ca.fabs(a.centre)
    whole = exponent.is_integer()
    if exponent < 0:
        inverse = invert(a)
        positive = _constant_power(inverse, -exponent)
        return positive._replace(conditions=inverse.conditions + positive.conditions)
    apart = a.centre >= a.radius
    conditions = () if whole else (apart,)
    centre = a.centre if whole else ca.if_else(apart, a.centre, 1)
    value = centre**exponent
    if exponent >= 1:
        slope = exponent * (size + a.radius) ** (exponent - 1)
        return Ball(value, a.radius * slope, conditions)
    return Ball(value, value - (centre - ca.if_else(apart, a.radius, 0)) ** exponent, conditions)


RULES: Final[Mapping[int, Callable[..., Ball]]] = {
    ca.OP_SQRT: root,
    ca.OP_EXP: exponential,
    ca.OP_EXPM1: exponential_less_one,
    ca.OP_LOG: logarithm,
    ca.OP_LOG1P: logarithm_of_one_more,
    ca.OP_POW: power,
    ca.OP_CONSTPOW: power,
}
