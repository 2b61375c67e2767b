"""States of the protected set at which the input has no effect on a row: there it holds or fails whatever is sent.

A relative degree is that of states in general position. Where ∂ψ_r/∂u vanishes, as in the middle of a disk to stay in
or at rest under a speed limit, the row is ψ_r(x) ≥ 0 alone. Such states are sought by Gauss–Newton steps from random
ones.
"""

from typing import Final

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign
from passafe.finding import Finding, Severity
from passafe.numerics.fixed_order import least_squares
from passafe.numerics.workspace import Array

STARTS: Final = 24
STEPS: Final = 20
VANISHED: Final = 1e-8
"""Effect, relative to the largest one met, that counts as none."""

ALLOWED: Final = 1e-9
"""ψ that counts as not negative: rounding."""


def vanishing_effect(design: FilterDesign, chain: BarrierChain, low: Array, high: Array, seed: int) -> Finding | None:
    """Return a finding where the input's effect on the row of a barrier vanishes in the protected set, else ``None``.

    Args:
        design: The design.
        chain: The chain of one of its barriers.
        low: Least corner of the box that states are drawn from, n numbers.
        high: Largest corner.
        seed: Seed of the states.
    """
    system = design.system
    effect = ca.densify(ca.jacobian(chain.psi[-1], system.u)).T
    at = [system.x, system.u, system.t]
    newton = ca.Function("newton", at, [effect, ca.densify(ca.jacobian(effect, system.x))])
    psi = ca.Function("psi", at, [ca.densify(ca.vertcat(*chain.psi))])
    centre = ca.DM(list(design.limits.centre))
    rng = np.random.default_rng(seed)
    lowest: tuple[float, Array] | None = None
    for start in rng.uniform(low, high, (STARTS, system.n)):
        x, largest, size = start, 0.0, np.inf
        for _ in range(STEPS):
            values, slope = (part.full() for part in newton(x, centre, 0.0))
            if not (np.isfinite(values).all() and np.isfinite(slope).all()):
                break
            size = float(np.abs(values).max())
            largest = max(largest, size)
            if size <= VANISHED * largest:
                break
            x = x - least_squares(slope, values.ravel())
        *before, last = psi(x, centre, 0.0).full().ravel()
        is_found = size <= VANISHED * largest and min(before) >= 0 and (x >= low).all() and (x <= high).all()
        if is_found and (lowest is None or last < lowest[0]):
            lowest = (float(last), x)
    return None if lowest is None else _finding(chain, *lowest)


def _finding(chain: BarrierChain, psi: float, x: Array) -> Finding:
    place = ", ".join(f"{value:.3g}" for value in x)
    holds = psi >= -ALLOWED
    return Finding(
        severity=Severity.NOTE if holds else Severity.WARNING,
        topic="relative degree",
        subject=f"barrier {chain.barrier.name!r}",
        found=f"the input's effect on its row vanishes at states such as ({place}): ψ is {psi:.3g} there",
        advice="" if holds else "another h, or a set in which this state is not: no input keeps the row there",
    )
