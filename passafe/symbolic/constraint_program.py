"""The constraints of the quadratic program, and the program's numbers that follow from a request."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca

from passafe.decision_schema import Linearization, Program, ReferenceInput, Request
from passafe.design import FilterDesign, Law
from passafe.enclosures.reachable_tube import reachable_tube, tube_of
from passafe.passivity import power_margin
from passafe.symbolic.enforced_barriers import EnforcedBarriers
from passafe.symbolic.enforced_passivity import EnforcedPassivity
from passafe.symbolic.rows import ConstraintRow, continuous_rows, stack


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Deviations:
    """Bounds of what is unknown over a period, for all inputs within the trust region.

    Attributes:
        barriers: Of every enforced barrier, shape (H, 1), in the units of ψ_r.
        power: Of the power margin, W.
        unknown: Number of these that are not known.
        uncertainty: What members of a family of plants take of every enforced barrier, in the units of ψ_r; empty for
            the model alone.
        power_uncertainty: The same of the power margin, W.
    """

    barriers: ca.SX
    power: ca.SX
    unknown: ca.SX
    uncertainty: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    power_uncertainty: ca.SX = field(default_factory=lambda: ca.SX(0, 1))

    @classmethod
    def of(
        cls,
        barriers: EnforcedBarriers,
        passivity: EnforcedPassivity | None,
        u_lin: ca.SX,
        trust: ca.SX,
        x_error: ca.SX,
    ) -> "Deviations":
        """Return the deviations for all inputs within ``trust`` of u_lin.

        Args:
            barriers: The enforced ones.
            passivity: Enforced, if it is.
            u_lin: Shape (m, 1).
            trust: Radius in each axis, shape (m, 1).
            x_error: Error of x, where a family of plants is asked for.
        """
        if barriers.family is not None:
            x_radius = ca.fabs(x_error)
            tube = tube_of(barriers.family.motion(x_radius, trust), barriers.design.held_s)
            sizes, less, unknown = barriers.member_bounds(tube, x_radius, u_lin, trust)
            if passivity is None or passivity.general is None:
                return cls(barriers=sizes, power=ca.SX(0), unknown=unknown, uncertainty=less)
            bound = passivity.member_bound(passivity.general, tube, x_radius, u_lin, trust)
            return cls(
                barriers=sizes,
                power=bound.deviation,
                unknown=unknown + 1 - bound.known,
                uncertainty=less,
                power_uncertainty=bound.uncertainty,
            )
        if not barriers.has_margins and (passivity is None or not passivity.has_margin):
            return cls(barriers=ca.SX.zeros(len(barriers.held)), power=ca.SX(0), unknown=ca.SX(0))
        tube = reachable_tube(barriers.design.system, barriers.design.held_s, trust)
        sizes, unknown = barriers.deviations(tube, u_lin, trust)
        power, power_unknown = (ca.SX(0), ca.SX(0)) if passivity is None else passivity.deviation(tube, u_lin, trust)
        return cls(barriers=sizes, power=power, unknown=unknown + power_unknown)


def taken_by_members(linearization: Linearization[ca.SX], uncertainty: ca.SX) -> ca.SX:
    """Return what rows leave to the members of a family: their uncertainty, or nothing where they are left out.

    Args:
        linearization: Symbols.
        uncertainty: Of every enforced barrier; empty for the model alone.
    """
    return linearization.with_sets * uncertainty if linearization.with_sets.numel() else uncertainty


def constraint_rows(
    barriers: EnforcedBarriers,
    passivity: EnforcedPassivity | None,
    linearization: Linearization[ca.SX],
    reference: ReferenceInput[ca.SX],
    deviations: Deviations,
) -> list[ConstraintRow]:
    """Return the constraints of the design's law and mode, hard ones first.

    Args:
        barriers: The enforced ones.
        passivity: Enforced under the sampled law, if it is.
        linearization: Symbols.
        reference: Of the request.
        deviations: Of all rows.
    """
    design, system = barriers.design, barriers.design.system
    if design.law is Law.CONTINUOUS:
        demand = design.passivity if design.mode.enforces_passivity else None
        h_u = power_margin(system, design.passivity.V)
        rate = (reference.u_ref - system.u) / design.dt_s
        return continuous_rows(system, barriers.chains, h_u, demand, rate, design.dt_s)
    u_ref, u_lin = reference.u_ref, linearization.u_lin
    rows = barriers.rows(
        u_ref,
        u_lin,
        deviations.barriers,
        taken_by_members(linearization, deviations.uncertainty),
        linearization.with_margins,
        linearization.tightening,
    )
    if passivity is not None:
        rows.append(passivity.row(u_ref, u_lin, deviations.power, deviations.power_uncertainty))
    return rows


def constraint_program(
    design: FilterDesign,
    rows: Sequence[ConstraintRow],
    request: Request[ca.SX],
    reference: ReferenceInput[ca.SX],
    trust: ca.SX,
    deviations: Deviations,
) -> tuple[Program[ca.SX], float]:
    """Return the program and √ρ of its soft row's slack, 0 without one.

    Args:
        design: The filter's.
        rows: Its constraints.
        request: Symbols.
        reference: Of the request.
        trust: Radius of the trust region in each axis, shape (m, 1).
        deviations: Of all rows.
    """
    G, d, root = stack(rows, design.system.m, reach=design.limits.reach)
    # fmin, fmax and mmax swallow a NaN; this is nothing for ordinary numbers and spoils the residual otherwise.
    asked = [request.x, request.u, request.u_h, request.u_h_rate, request.tank, request.t, request.x_error]
    guarded = ca.vertcat(*asked, reference.phi, *(row.value for row in rows))
    program = Program(
        **reference.fields(),
        trust=trust,
        deviation=deviations.barriers,
        power_deviation=deviations.power,
        uncertainty=deviations.uncertainty,
        power_uncertainty=deviations.power_uncertainty,
        unbounded=deviations.unknown,
        G=G,
        d=d,
        largest_bound=ca.mmax(d) if rows else ca.SX(0),
        nan_guard=1e-300 * ca.sumsqr(guarded),
    )
    return program, root
