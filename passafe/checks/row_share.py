"""Findings that take decisions: where rows can be kept, and whether operators drive the robot to where they cannot."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isfinite
from typing import Final

import casadi as ca
import numpy as np

from passafe.arguments.numbers import numbers
from passafe.checks.backup_start import backup_findings, is_kept_from
from passafe.checks.driven_states import EASIER, driven_findings
from passafe.checks.vanishing_effect import vanishing_effect
from passafe.decision import Status
from passafe.errors import DesignError, ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity
from passafe.numerics.workspace import Array

MOST_DRAWS: Final = 50
"""States that are drawn for each that is wanted, at most: many lie outside the protected set."""

ENOUGH: Final = 0.9
"""Share of random states with margins below which there is a warning: those need not be states that anybody reaches."""

FEWEST: Final = 20
"""States from which on a share of zero says that a design is of no use."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StateBox:
    """Start, and box from which states are drawn.

    Attributes:
        x0: State at the start, n numbers.
        low: Least corner of the box of random states.
        high: Largest corner.
    """

    x0: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def __post_init__(self) -> None:
        """Take numbers in every form that is allowed, and refuse corners between which there is nothing."""
        for name in ("x0", "low", "high"):
            object.__setattr__(self, name, numbers(f"state box {name}", getattr(self, name)))
        if len({len(self.x0), len(self.low), len(self.high)}) != 1:
            raise ShapeError("state box", f"{len(self.x0)}, {len(self.low)}, {len(self.high)} numbers", "as many each")
        finite = all(isfinite(each) for each in (*self.x0, *self.low, *self.high))
        if not finite or any(low > high for low, high in zip(self.low, self.high, strict=True)):
            raise DesignError("state box", f"{self.low}, {self.high}", "finite, no low above its high")


def row_findings(core: SafetyPassivityFilter, box: StateBox, samples: int, seed: int) -> tuple[Finding, ...]:
    """Return what decisions show of the rows, of random states, of operators and of the fail-safe law from the start.

    Args:
        core: The filter.
        box: Where states are drawn from.
        samples: Number of random states.
        seed: Seed of states and operators.
    """
    zero = (0.0,) * core.design.system.m
    tank_j = core.design.passivity.initial_j
    drawn = Counter(
        core.decide(x, zero, zero, zero, tank_j, start=True).status for x in _random(core, box, samples, seed)
    )
    low, high = np.array(box.low), np.array(box.high)
    effects = (vanishing_effect(core.design, chain, low, high, seed) for chain in core.chains)
    of_rows = (*(finding for finding in effects if finding is not None), _share(drawn))
    if core.design.gatekeeper and is_kept_from(core, box.x0):
        of_rows = tuple(map(_harmless, of_rows))
    return (*of_rows, *driven_findings(core, box.x0, samples, seed), *backup_findings(core, box.x0))


def _harmless(finding: Finding) -> Finding:
    """Return a finding as a note: from a start that the gatekeeper keeps, no row need be kept (theorem 3)."""
    return replace(finding, severity=Severity.NOTE) if finding.severity is Severity.WARNING else finding


def _share(statuses: Counter[Status]) -> Finding:
    count = statuses.total()
    never, not_between = statuses[Status.INFEASIBLE], statuses[Status.AT_SAMPLES] + statuses[Status.UNCERTIFIED]
    with_margin, at_all = count - never - not_between, count - never
    found = (
        f"of {count} in the protected set, rows can be kept with margins in {with_margin}, without in {at_all}"
        if count
        else "none of those drawn is in the protected set"
    )
    severity, advice = Severity.NOTE, ""
    if with_margin < count:
        severity = Severity.WARNING if with_margin < ENOUGH * count else Severity.NOTE
        advice = f"{EASIER}; see `passafe feasibility`"
    if at_all == 0 and count >= FEWEST:
        severity = Severity.REFUSED
    return Finding(severity=severity, topic="rows", subject="random states", found=found, advice=advice)


def _random(core: SafetyPassivityFilter, box: StateBox, samples: int, seed: int) -> Iterator[list[float]]:
    """Yield random states of the protected set."""
    system = core.design.system
    protected = [psi for chain in core.chains for psi in chain.psi[:-1]]
    inside = ca.Function("inside", [system.x, system.t], [ca.densify(ca.vertcat(ca.SX(np.inf), *protected))])
    rng = np.random.default_rng(seed)
    drawn: Array = rng.uniform(box.low, box.high, (MOST_DRAWS * samples, system.n)).T
    kept = inside(ca.DM(drawn), 0.0).full().min(axis=0) >= 0
    yield from drawn[:, kept].T[:samples].tolist()
