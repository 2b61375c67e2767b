"""Slopes that a decision needs and that are no numbers in some state, as that of a norm at zero."""

from collections.abc import Iterator, Sequence

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign
from passafe.finding import Finding, Severity
from passafe.passivity import power_margin


def undefined_at(
    design: FilterDesign, chains: Sequence[BarrierChain], x: Sequence[float], t_s: float
) -> Iterator[Finding]:
    """Yield the parts of a design whose slopes are no numbers in a state: there every decision is ``UNCERTIFIED``.

    Args:
        design: The design.
        chains: The chains of its barriers.
        x: The state, n numbers.
        t_s: Plant time, s.
    """
    system = design.system
    needed = {"feedback u_fb": ca.jtimes(design.u_fb, system.x, system.f)}
    if design.mode.enforces_passivity:
        needed["storage V"] = power_margin(system, design.passivity.V)
    if design.mode.enforces_safety:
        needed |= {f"barrier {chain.barrier.name!r} h": ca.vertcat(*chain.psi) for chain in chains}
    for part, expression in needed.items():
        both = ca.densify(ca.vertcat(expression, ca.vec(ca.jacobian(expression, system.u))))
        values = ca.Function("needed", [system.x, system.u, system.t], [both])
        if not np.isfinite(values(ca.DM(list(x)), ca.DM(list(design.limits.centre)), t_s).full()).all():
            yield Finding(
                severity=Severity.WARNING,
                topic="slope",
                subject=part,
                found="it, or a time derivative that the filter needs, is no number at the start: no decision is "
                "certified there",
                advice="√(‖v‖² + ε²) with a small ε for a norm ‖v‖, which has no slope at zero, and likewise for other "
                "roots; or another start",
            )
