"""The evaluation of an answer: the input that is sent, margins and barrier chains under it, and its assessment."""

from collections.abc import Sequence
from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.certificate import certificate_residuals
from passafe.decision_schema import Answer, Assessment, Evaluation, Linearization, NormTangents, Program, Request
from passafe.design import FilterDesign
from passafe.passivity import power_margin
from passafe.symbolic.constraint_program import taken_by_members
from passafe.symbolic.enforced_barriers import EnforcedBarriers
from passafe.symbolic.enforced_passivity import EnforcedPassivity
from passafe.symbolic.trust_region import outside_trust_region
from passafe.symbolic.whole_program import overreach, whole_rows

UNPROTECTED: Final = -1e-9
"""Value of a ψ below which the state counts as outside of the protected set."""

SPARED: Final = 0.05
"""Distance that a margin may keep answers away by what is unknown alone, relative to the trust region's radius.

More would add up: what is asked for moves with the input before, so that a robot would drift away tick by tick.
"""


def evaluate(
    chains: Sequence[BarrierChain],
    barriers: EnforcedBarriers,
    passivity: EnforcedPassivity | None,
    request: Request[ca.SX],
    linearization: Linearization[ca.SX],
    program: Program[ca.SX],
    tangents: NormTangents[ca.SX],
    answer: Answer[ca.SX],
    root: float,
) -> tuple[Evaluation[ca.SX], Assessment[ca.SX]]:
    """Return evaluation and assessment of an answer to the whole program.

    Args:
        chains: Chains of all barriers, enforced or not.
        barriers: The enforced ones.
        passivity: Enforced, if it is.
        request: Symbols.
        linearization: Symbols.
        program: Symbols.
        tangents: Symbols.
        answer: Symbols.
        root: √ρ of the soft row's slack; 0 without one.
    """
    design, m, hard = barriers.design, request.u.numel(), answer.relax.numel()
    G, d = whole_rows(program, tangents.cuts, design.limits)
    residuals = certificate_residuals(answer.z, answer.lam, G, ca.vertcat(d[:hard] - answer.relax, d[hard:]))
    unclipped = program.u_ref + answer.z[:m]
    u_plus = design.limits.clip(unclipped, request.u, program.low, program.high)
    psi, h_u = _at(design, chains, u_plus)
    eps = linearization.with_margins * barriers.margins(u_plus, program.deviation)
    is_for_model = barriers.family is None
    uncertainty = taken_by_members(linearization, program.uncertainty)
    counted = answer.z[m] / root if root else ca.SX(0)
    slack = (
        counted if passivity is None else passivity.slack(u_plus, program.power_deviation, program.power_uncertainty)
    )
    has_margins = barriers.has_margins or (passivity is not None and passivity.has_margin)
    evaluation = Evaluation(
        margins=G @ answer.z - d,
        u_plus=u_plus,
        v=(u_plus - request.u) / design.dt_s - program.phi,
        psi=psi,
        eps=eps if is_for_model else eps + uncertainty,
        h_u=h_u,
    )
    shortfall, lost = barriers.graded(u_plus, eps, program.deviation, uncertainty)
    waste = lost - SPARED * ca.mmax(program.trust)
    unknown = linearization.with_margins * program.unbounded
    outside = (
        linearization.with_margins * outside_trust_region(linearization, u_plus, program.trust)
        if has_margins
        else ca.SX(0)
    )
    lowest_psi = barriers.lowest_psi()
    concerns = [
        shortfall,
        outside,
        unknown,
        slack - design.passivity.relaxed_above,
        # Courses of the backup law are the model's: for a family of plants they prove nothing.
        *([UNPROTECTED - lowest_psi] if is_for_model else []),
        waste,
    ]
    assessment = Assessment(
        primal=residuals.primal + program.nan_guard,
        dual=residuals.dual,
        gap=residuals.gap,
        norm_overreach=overreach(design.limits, unclipped),
        slack=slack,
        extra_slack=slack - counted,
        shortfall=shortfall,
        outside_trust_region=outside,
        unknown_margins=unknown,
        lowest_psi=lowest_psi,
        waste=waste,
        concern=ca.SX(1) if design.gatekeeper else ca.mmax(ca.vertcat(*concerns)),
    )
    return evaluation, assessment


def _at(design: FilterDesign, chains: Sequence[BarrierChain], u_plus: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return ψ₀ … ψ_r of all chains and the power margin under an input."""
    system = design.system
    psi = ca.vertcat(ca.SX(0, 1), *(psi for chain in chains for psi in chain.psi))
    psi, h_u = ca.substitute([psi, power_margin(system, design.passivity.V)], [system.u], [u_plus])
    return psi, h_u
