"""Balls of sine and cosine."""

from collections.abc import Callable, Mapping
from typing import Final

import casadi as ca

from passafe.enclosures.rules.ball import Ball


def sine(a: Ball) -> Ball:
    """Return the ball of sin a."""
    return Ball(ca.sin(a.centre), _reach(ca.sin(a.centre), ca.cos(a.centre), a.radius))


def cosine(a: Ball) -> Ball:
    """Return the ball of cos a."""
    return Ball(ca.cos(a.centre), _reach(ca.cos(a.centre), ca.sin(a.centre), a.radius))


def _reach(value: ca.SX, slope: ca.SX, radius: ca.SX) -> ca.SX:
    """Return the least of three bounds: slope and bend at the centre, the steepest slope, and the ends −1 and 1."""
    bent = radius * (ca.fabs(slope) + ca.fabs(value) * radius / 2)
    return ca.fmin(ca.fmin(bent, radius), 1 + ca.fabs(value))


RULES: Final[Mapping[int, Callable[..., Ball]]] = {ca.OP_SIN: sine, ca.OP_COS: cosine}
