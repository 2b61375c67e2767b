"""Balls: midpoint–radius pairs, and the conditions under which they enclose what they should."""

from typing import Final, NamedTuple

import casadi as ca

LARGEST: Final = 1e300
"""Magnitude up to which a number counts as finite: what a rule makes from larger ones may be infinite or NaN."""


class Ball(NamedTuple):
    """All numbers within ``radius`` of ``centre``, provided that all of ``conditions`` hold.

    Attributes:
        centre: Scalar expression.
        radius: Scalar expression.
        conditions: Truth values, 0 or 1. Where one is 0, centre and radius are finite or not, but mean nothing.
    """

    centre: ca.SX
    radius: ca.SX
    conditions: tuple[ca.SX, ...] = ()


def within_range(a: Ball) -> tuple[ca.SX, ...]:
    """Return the condition that a ball's centre has not overflowed, for rules that give finite values anyway."""
    return () if a.centre.is_constant() or a.centre.is_symbolic() else (ca.fabs(a.centre) < LARGEST,)
