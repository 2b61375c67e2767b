"""States that operators at the limits reach from the start, through the filter: can rows be kept there?

Random states say how much of the protected set is good; these say whether a robot gets to where it is not. Some
operators ask for the same corner of the limits all the time, as one who drives at a wall; others change it now and
then.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from passafe.decision import Status
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity
from passafe.sampled_plant import SampledPlant

OPERATORS: Final = 8
"""Operators that drive from the start."""

CHANGES: Final = 0.05
"""Share of the periods at which every other one of them asks for something else."""

DRIVEN_S: Final = 3.0
"""Plant time for which each drives, unless that is less than ``FEWEST`` periods or more than are allowed, s."""

FEWEST: Final = 50

EASIER: Final = "wider limits of the input, lower gains, a higher rate or a shorter hold"
"""Changes of a design that make its rows easier to keep."""

MOSTLY: Final = 0.5
"""Share of periods in which the backup law brakes from which on the robot counts as not drivable."""

PERIODS: Final = 10
"""Periods that one operator drives at most, for every random state that is looked at."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FallbackReached:
    """A fallback that an operator drove into.

    Attributes:
        after_s: Plant time since the start, s.
        status: Why it is one.
        x: State.
    """

    after_s: float
    status: Status
    x: tuple[float, ...]

    def __str__(self) -> str:
        """Return it as part of a sentence."""
        place = ", ".join(f"{value:.3g}" for value in self.x)
        return f"{self.status.name} after {self.after_s:.3g} s at ({place})"


def driven_finding(
    core: SafetyPassivityFilter, x0: Sequence[float], samples: int, seed: int, operators: int = OPERATORS
) -> Finding:
    """Return whether any operator drives the robot from the start into a fallback, and where the first one is.

    Args:
        core: The filter.
        x0: Start, n numbers.
        samples: Number of random states of the same check, which bounds the time of this part, too.
        seed: Seed of the operators.
        operators: How many drive.
    """
    dt_s = core.design.dt_s
    periods = int(np.clip(round(DRIVEN_S / dt_s), FEWEST, PERIODS * samples))
    drives = [_drive(core, x0, periods, seed, k) for k in range(operators)]
    reached = [drive.fallback for drive in drives if drive.fallback is not None]
    drove = f"{operators} operators drove from the start at the limits of the input for {periods * dt_s:.3g} s"
    subject = "states that operators reach from the start"
    braked = sum(drive.braked for drive in drives) / sum(drive.periods for drive in drives)
    if not reached and braked < MOSTLY:
        return Finding(severity=Severity.NOTE, topic="rows", subject=subject, found=f"{drove}: no fallback")
    if not reached:
        found, advice = f"{drove}: the backup law braked in {braked:.0%} of the periods", EASIER
    else:
        first = min(reached, key=lambda end: end.after_s)
        found = f"{drove}: {len(reached)} of them into a fallback, first {first}"
        advice = f"{'' if core.design.gatekeeper else 'a gatekeeper, '}{EASIER}"
    return Finding(severity=Severity.WARNING, topic="rows", subject=subject, found=found, advice=advice)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Drive:
    """Outcome of one operator's drive.

    Attributes:
        periods: Periods driven.
        braked: Those in which the backup law's input was sent.
        fallback: Fallback that ended it; ``None`` if none did.
    """

    periods: int
    braked: int
    fallback: FallbackReached | None


def _drive(core: SafetyPassivityFilter, x0: Sequence[float], periods: int, seed: int, operator: int) -> _Drive:
    design, tank_j = core.design, core.design.passivity.initial_j
    plant = SampledPlant(design.system, design.passivity.V, design.dt_s)
    requests = _requests(core, np.random.default_rng([seed, operator]), changes=operator % 2 == 1)
    x, u, rest = x0, design.limits.centre, (0.0,) * design.system.m
    braked = 0
    for k in range(periods):
        t_s = k * design.dt_s
        decision = core.decide(x, u, next(requests), rest, tank_j, t_s, start=k == 0)
        if decision.status.is_fallback:
            reached = FallbackReached(after_s=t_s, status=decision.status, x=tuple(x))
            return _Drive(periods=k + 1, braked=braked, fallback=reached)
        braked += decision.status is Status.BACKUP
        x, u = plant.advance(x, decision.u).x, decision.u
    return _Drive(periods=periods, braked=braked, fallback=None)


def _requests(core: SafetyPassivityFilter, rng: np.random.Generator, *, changes: bool) -> Iterator[list[float]]:
    """Yield what an operator asks for in period after period: a corner of the limits."""
    sides = np.array((core.design.limits.low, core.design.limits.high))
    corner = rng.permuted(sides, axis=0)[0]
    while True:
        if changes and rng.random() < CHANGES:
            corner = rng.permuted(sides, axis=0)[0]
        yield corner.tolist()
