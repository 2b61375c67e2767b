"""The input that the filter would send if no row stood in the way."""

from dataclasses import dataclass

import casadi as ca

from passafe.decision_schema import Request
from passafe.design import FilterDesign
from passafe.tracking import nominal_input, tracking_rate


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class ReferenceInput:
    """Expressions of a request, each of shape (m, 1).

    Attributes:
        u_nominal: û = u_fb(x) + u_h, units of u.
        phi: Tracking term φ, units of u per second.
        low: Least input that magnitude and rate allow, units of u.
        high: Largest one, units of u.
        u_ref: u + dt·φ, or û at the start, clipped to ``low`` and ``high``: where z = 0.
    """

    u_nominal: ca.SX
    phi: ca.SX
    low: ca.SX
    high: ca.SX
    u_ref: ca.SX


def reference_input(design: FilterDesign, request: Request[ca.SX]) -> ReferenceInput:
    """Return the reference input of a request and what it is made from.

    Args:
        design: The filter's.
        request: Symbols.
    """
    u_nominal = nominal_input(design.u_fb, request.u_h)
    phi = tracking_rate(design.system, design.u_fb, request.u_h, request.u_h_rate, design.k_i)
    low, high = _interval(design, request)
    wanted = ca.if_else(request.start, u_nominal, request.u + design.dt_s * phi)
    u_ref = ca.fmin(ca.fmax(wanted, low), high)
    return ReferenceInput(u_nominal=u_nominal, phi=phi, low=low, high=high, u_ref=u_ref)


def _interval(design: FilterDesign, request: Request[ca.SX]) -> tuple[ca.SX, ca.SX]:
    """Return the least and largest input; at the start there is no input before that limits the rate."""
    limits = design.limits
    low, high = limits.interval(request.u, design.dt_s)
    if limits.rate_per_s is None:
        return low, high
    b = ca.DM(list(limits.magnitude))
    return ca.if_else(request.start, -b, low), ca.if_else(request.start, b, high)
