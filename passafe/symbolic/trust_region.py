"""The trust region of a decision: the box about u_lin in which its margins between samples are valid."""

from typing import Final

import casadi as ca

from passafe.decision_schema import Linearization
from passafe.limits import Limits

LEAST_TRUST: Final = 1e-3
"""Smallest radius, relative to the magnitude of u."""


def trust_radius(limits: Limits, linearization: Linearization[ca.SX], u_ref: ca.SX) -> ca.SX:
    """Return the radius in each axis, shape (m, 1), units of u: the one asked for, else one that reaches u_ref.

    Args:
        limits: The filter's.
        linearization: Symbols.
        u_ref: Reference input, expression, shape (m, 1).
    """
    nearby = ca.mmax(ca.fabs(u_ref - linearization.u_lin)) + LEAST_TRUST * ca.DM(list(limits.magnitude))
    return ca.if_else(linearization.trust_asked > 0, linearization.trust_asked, nearby)


def outside_trust_region(linearization: Linearization[ca.SX], u_plus: ca.SX, trust: ca.SX) -> ca.SX:
    """Return the distance of u⁺ from the trust region, scalar, units of u; ≤ 0 inside.

    Args:
        linearization: Symbols.
        u_plus: u⁺, expression, shape (m, 1).
        trust: Radius in each axis, shape (m, 1).
    """
    return ca.mmax(ca.fabs(u_plus - linearization.u_lin) - trust)
