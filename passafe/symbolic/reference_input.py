"""The input that the filter would send if no row stood in the way."""

import casadi as ca

from passafe.decision_schema import ReferenceInput, Request
from passafe.design import FilterDesign
from passafe.symbolic.tracking import nominal_input, tracking_rate


def reference_input(design: FilterDesign, request: Request[ca.SX]) -> ReferenceInput[ca.SX]:
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
    return ReferenceInput(u_nominal=u_nominal, phi=phi, u_ref=u_ref, low=low, high=high)


def _interval(design: FilterDesign, request: Request[ca.SX]) -> tuple[ca.SX, ca.SX]:
    """Return the least and largest input; at the start there is no input before that limits the rate."""
    limits = design.limits
    low, high = limits.interval(request.u, design.dt_s)
    if limits.rise_per_s is None:
        return low, high
    least, most = ca.DM(list(limits.low)), ca.DM(list(limits.high))
    return ca.if_else(request.start, least, low), ca.if_else(request.start, most, high)
