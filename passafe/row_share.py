"""The share of states in which the rows of a design can be kept: of random ones, and of those that operators reach."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca
import numpy as np

from passafe.decision import Status
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity
from passafe.sampled_plant import SampledPlant
from passafe.vanishing_effect import vanishing_effect
from passafe.workspace import Array

OPERATORS: Final = 8
"""Random operators that drive from the start, each with a request that it changes now and then."""

CHANGES: Final = 0.05
"""Share of the periods at which such an operator changes its request."""

MOST_DRAWS: Final = 50
"""States that are drawn for each that is wanted, at most: many lie outside the protected set."""

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


def row_findings(core: SafetyPassivityFilter, box: StateBox, samples: int, seed: int) -> tuple[Finding, ...]:
    """Return what decisions show: shares of states in which rows can be kept, and where an input has no effect on one.

    The states are random ones of the protected set, and those that random operators reach.

    Args:
        core: The filter.
        box: Where states are drawn from.
        samples: Number of states of each kind.
        seed: Seed of states and operators.
    """
    zero = (0.0,) * core.design.system.m
    drawn = Counter(
        core.decide(x, zero, zero, zero, _tank_j(core), start=True).status for x in _random(core, box, samples, seed)
    )
    reached = Counter(_reached(core, box, samples, seed))
    low, high = np.array(box.low), np.array(box.high)
    effects = (vanishing_effect(core.design, chain, low, high, seed) for chain in core.chains)
    return (
        *(finding for finding in effects if finding is not None),
        _share("random states", drawn),
        _share("states that operators reach from the start", reached),
    )


def _share(subject: str, statuses: Counter[Status]) -> Finding:
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
        severity = Severity.WARNING
        advice = "wider limits of the input, lower gains, a higher rate or a shorter hold; see `passafe feasibility`"
    if at_all == 0 and count >= FEWEST:
        severity = Severity.REFUSED
    return Finding(severity=severity, topic="rows", subject=subject, found=found, advice=advice)


def _random(core: SafetyPassivityFilter, box: StateBox, samples: int, seed: int) -> Iterator[list[float]]:
    """Yield random states of the protected set."""
    system = core.design.system
    protected = [psi for chain in core.chains for psi in chain.psi[:-1]]
    inside = ca.Function("inside", [system.x, system.t], [ca.densify(ca.vertcat(ca.SX(np.inf), *protected))])
    rng = np.random.default_rng(seed)
    drawn: Array = rng.uniform(box.low, box.high, (MOST_DRAWS * samples, system.n)).T
    kept = inside(ca.DM(drawn), 0.0).full().min(axis=0) >= 0
    yield from drawn[:, kept].T[:samples].tolist()


def _reached(core: SafetyPassivityFilter, box: StateBox, samples: int, seed: int) -> Iterator[Status]:
    """Yield the statuses of decisions in states that random operators reach through the filter, from the start."""
    design = core.design
    plant = SampledPlant(design.system, design.passivity.V, design.dt_s)
    rng = np.random.default_rng(seed)
    low, high = np.array(design.limits.low), np.array(design.limits.high)
    rest = (0.0,) * design.system.m
    for _ in range(OPERATORS):
        x: Sequence[float] = box.x0
        u: Sequence[float] = design.limits.centre
        t_s, u_h = 0.0, rng.uniform(low, high)
        for k in range(samples // OPERATORS):
            if rng.uniform() < CHANGES:
                u_h = rng.uniform(low, high)
            decision = core.decide(x, u, u_h.tolist(), rest, _tank_j(core), t_s, start=k == 0)
            yield decision.status
            u = decision.u
            x = plant.advance(x, u).x
            t_s += design.dt_s


def _tank_j(core: SafetyPassivityFilter) -> float:
    tank = core.design.passivity.tank
    return 0.0 if tank is None else tank.initial_j
