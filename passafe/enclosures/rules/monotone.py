"""Balls of odd functions that grow steadily, and of their relatives: inverse and hyperbolic functions, errors.

Each is odd, so only the size of the centre matters: ``inner`` and ``outer`` are the ends towards zero and away from it.
Differences are written so that they do not cancel where the radius is small.
"""

from collections.abc import Callable, Mapping
from math import pi, sqrt
from typing import Final

import casadi as ca

from passafe.enclosures.rules.ball import Ball, within_range

POLE: Final = pi / 2 - 1e-9
"""How far from a multiple of π a tangent's argument may reach: up to a slope of 1e18."""


def arctangent(a: Ball) -> Ball:
    """Return the ball of atan a: atan s − atan(s − r) = atan(r / (1 + s(s − r))), in the right quadrant."""
    size = ca.fabs(a.centre)
    return Ball(ca.atan(a.centre), ca.atan2(a.radius, 1 + size * (size - a.radius)), within_range(a))


def hyperbolic_tangent(a: Ball) -> Ball:
    """Return the ball of tanh a: tanh s − tanh(s − r) = tanh r · (1 − tanh s · tanh(s − r))."""
    size = ca.fabs(a.centre)
    fall = 1 - ca.tanh(size) * ca.tanh(size - a.radius)
    return Ball(ca.tanh(a.centre), ca.tanh(a.radius) * fall, within_range(a))


def inverse_hyperbolic_sine(a: Ball) -> Ball:
    """Return the ball of asinh a, by its steepest slope, 1/√(1 + s²) at the inner end."""
    inner = ca.fmax(ca.fabs(a.centre) - a.radius, 0)
    return Ball(ca.asinh(a.centre), a.radius / ca.hypot(1, inner))


def error_function(a: Ball) -> Ball:
    """Return the ball of erf a, by its steepest slope, 2/√π · e^(−s²) at the inner end; nothing is beyond ±1."""
    inner = ca.fmax(ca.fabs(a.centre) - a.radius, 0)
    value = ca.erf(a.centre)
    return Ball(value, ca.fmin(2 / sqrt(pi) * a.radius * ca.exp(-inner * inner), 1 + ca.fabs(value)), within_range(a))


def tangent(a: Ball) -> Ball:
    """Return the ball of tan a, where no pole is within reach: tan(a ± r) − tan a = sin(±r) / (cos a · cos(a ± r))."""
    size = ca.fabs(ca.atan(ca.tan(a.centre)))
    apart = size + a.radius < POLE
    inside = ca.if_else(apart, size, 0)
    radius = ca.if_else(apart, a.radius, 0)
    value = ca.if_else(apart, ca.tan(a.centre), 0)
    return Ball(value, ca.sin(radius) / (ca.cos(inside) * ca.cos(inside + radius)), (apart,))


def inverse_hyperbolic_tangent(a: Ball) -> Ball:
    """Return the ball of atanh a, within (−1, 1): atanh(s + r) − atanh s = atanh(r / (1 − s(s + r)))."""
    size, centre, radius, apart = _inside_one(a, ca.lt)
    return Ball(ca.atanh(centre), ca.atanh(radius / (1 - size * (size + radius))), (apart,))


def arcsine(a: Ball) -> Ball:
    """Return the ball of asin a, within [−1, 1]: steepest at the outer end."""
    size, centre, radius, apart = _inside_one(a, ca.le)
    return Ball(ca.asin(centre), ca.asin(size + radius) - ca.asin(size), (apart,))


def arccosine(a: Ball) -> Ball:
    """Return the ball of acos a = π/2 − asin a."""
    _, centre, _, _ = _inside_one(a, ca.le)
    return arcsine(a)._replace(centre=ca.acos(centre))


def inverse_error_function(a: Ball) -> Ball:
    """Return the ball of the inverse of erf, within (−1, 1): steepest at the outer end."""
    size, centre, radius, apart = _inside_one(a, ca.lt)
    return Ball(ca.erfinv(centre), ca.erfinv(size + radius) - ca.erfinv(size), (apart,))


def inverse_hyperbolic_cosine(a: Ball) -> Ball:
    """Return the ball of acosh a, from 1 on: concave, so furthest from the centre's at the lower end."""
    apart = a.centre - a.radius >= 1
    centre = ca.if_else(apart, a.centre, 1)
    return Ball(ca.acosh(centre), ca.acosh(centre) - ca.acosh(centre - ca.if_else(apart, a.radius, 0)), (apart,))


def hyperbolic_sine(a: Ball) -> Ball:
    """Return the ball of sinh a: sinh(a ± r) − sinh a = sinh a (cosh r − 1) ± cosh a sinh r."""
    grown = ca.cosh(a.centre) * ca.sinh(a.radius) + ca.fabs(ca.sinh(a.centre)) * _cosh_less_one(a.radius)
    return Ball(ca.sinh(a.centre), grown)


def hyperbolic_cosine(a: Ball) -> Ball:
    """Return the ball of cosh a: cosh(a ± r) − cosh a = cosh a (cosh r − 1) ± sinh a sinh r."""
    grown = ca.cosh(a.centre) * _cosh_less_one(a.radius) + ca.fabs(ca.sinh(a.centre)) * ca.sinh(a.radius)
    return Ball(ca.cosh(a.centre), grown)


def _cosh_less_one(radius: ca.SX) -> ca.SX:
    return 2 * ca.sinh(radius / 2) * ca.sinh(radius / 2)


def _inside_one(a: Ball, compare: Callable[[ca.SX, float], ca.SX]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Return size, centre and radius of a ball inside (−1, 1) or [−1, 1], all 0 elsewhere, and whether it is."""
    apart = compare(ca.fabs(a.centre) + a.radius, 1)
    centre = ca.if_else(apart, a.centre, 0)
    return ca.fabs(centre), centre, ca.if_else(apart, a.radius, 0), apart


RULES: Final[Mapping[int, Callable[..., Ball]]] = {
    ca.OP_ATAN: arctangent,
    ca.OP_TANH: hyperbolic_tangent,
    ca.OP_ASINH: inverse_hyperbolic_sine,
    ca.OP_ERF: error_function,
    ca.OP_TAN: tangent,
    ca.OP_ATANH: inverse_hyperbolic_tangent,
    ca.OP_ASIN: arcsine,
    ca.OP_ACOS: arccosine,
    ca.OP_ERFINV: inverse_error_function,
    ca.OP_ACOSH: inverse_hyperbolic_cosine,
    ca.OP_SINH: hyperbolic_sine,
    ca.OP_COSH: hyperbolic_cosine,
}
