"""The constraints of the quadratic program, and the program's numbers that follow from a request."""

from collections.abc import Sequence

import casadi as ca

from passafe.decision_schema import Linearization, Program, ReferenceInput, Request
from passafe.design import FilterDesign, Law
from passafe.passivity import power_margin
from passafe.rows import ConstraintRow, continuous_rows, passivity_row, stack
from passafe.symbolic.enforced_barriers import EnforcedBarriers


def constraint_rows(
    barriers: EnforcedBarriers,
    request: Request[ca.SX],
    linearization: Linearization[ca.SX],
    reference: ReferenceInput[ca.SX],
    eps: ca.SX,
) -> list[ConstraintRow]:
    """Return the constraints of the design's law and mode, hard ones first.

    Args:
        barriers: The enforced ones.
        request: Symbols.
        linearization: Symbols.
        reference: Of the request.
        eps: Margins between samples of all enforced barriers.
    """
    design, system = barriers.design, barriers.design.system
    passivity = design.passivity if design.mode.enforces_passivity else None
    h_u = power_margin(system, design.passivity.V)
    if design.law is Law.CONTINUOUS:
        rate = (reference.u_ref - system.u) / design.dt_s
        return continuous_rows(system, barriers.chains, h_u, passivity, rate, design.dt_s)
    rows = barriers.rows(reference.u_ref, linearization.u_lin, eps, linearization.tightening)
    if passivity is not None:
        rows.append(passivity_row(system, h_u, passivity, reference.u_ref, linearization.u_lin, request.tank))
    return rows


def constraint_program(
    design: FilterDesign,
    rows: Sequence[ConstraintRow],
    request: Request[ca.SX],
    reference: ReferenceInput[ca.SX],
    trust: ca.SX,
    eps: ca.SX,
) -> tuple[Program[ca.SX], float]:
    """Return the program and √ρ of its soft row's slack, 0 without one.

    Args:
        design: The filter's.
        rows: Its constraints.
        request: Symbols.
        reference: Of the request.
        trust: Radius of the trust region in each axis, shape (m, 1).
        eps: Margins between samples of all enforced barriers.
    """
    G, d, root = stack(rows, design.system.m, reach=design.limits.reach)
    # fmin, fmax and mmax swallow a NaN; this is nothing for ordinary numbers and spoils the residual otherwise.
    asked = [request.x, request.u, request.u_h, request.u_h_rate, request.tank, request.t]
    guarded = ca.vertcat(*asked, reference.phi, *(row.value for row in rows))
    program = Program(
        **reference.fields(),
        trust=trust,
        eps=eps,
        G=G,
        d=d,
        largest_bound=ca.mmax(d) if rows else ca.SX(0),
        nan_guard=1e-300 * ca.sumsqr(guarded),
    )
    return program, root
