"""States that operators at the limits reach from the start, through the filter: can rows be kept there, and the tank?

Random states say how much of the protected set is good; these say whether a robot gets to where it is not.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from passafe.checks.backup_start import UNSTEADY, FailSafeCourses, unsteady
from passafe.checks.drive import Drive, drive
from passafe.decision import Status
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity

OPERATORS: Final = 8
"""Operators that drive from the start."""

DRIVEN_S: Final = 3.0
"""Plant time for which each drives, unless that is less than ``FEWEST`` periods or more than are allowed, s."""

FEWEST: Final = 50

EASIER: Final = "wider limits of the input, lower gains, a higher rate or a shorter hold"
"""Changes of a design that make its rows easier to keep."""

MOSTLY: Final = 0.5
"""Share of periods in which the backup law brakes from which on the robot counts as not drivable."""

PERIODS: Final = 10
"""Periods that one operator drives at most, for every random state that is looked at."""

TANK_ROUNDING: Final = 1e-9
"""Share of the tank's first energy by which rounding may take it below zero."""

SUBJECT: Final = "states that operators reach from the start"


def driven_findings(
    core: SafetyPassivityFilter, x0: Sequence[float], samples: int, seed: int, operators: int = OPERATORS
) -> tuple[Finding, ...]:
    """Return whether any operator drives the robot from the start into a fallback, and whether one empties the tank.

    Where the backup law was sent, also whether it holds what it promises there if its inputs are lost.

    Args:
        core: The filter.
        x0: Start, n numbers.
        samples: Number of random states of the same check, which bounds the time of this part, too.
        seed: Seed of the operators.
        operators: How many drive.
    """
    dt_s = core.design.dt_s
    periods = int(np.clip(round(DRIVEN_S / dt_s), FEWEST, PERIODS * samples))
    drives = [drive(core.design, core.decide, x0, periods, seed, k) for k in range(operators)]
    drove = f"{operators} operators drove from the start at the limits of the input for {periods * dt_s:.3g} s"
    energy = (_energy(core, drives, drove),) if core.design.mode.enforces_passivity else ()
    return (_rows(core, drives, drove), *energy, *_unsteady(core, drives))


def _rows(core: SafetyPassivityFilter, drives: Sequence[Drive], drove: str) -> Finding:
    reached = [each.fallback for each in drives if each.fallback is not None]
    braked = _share(drives, Status.BACKUP)
    if not reached and braked < MOSTLY:
        return Finding(severity=Severity.NOTE, topic="rows", subject=SUBJECT, found=f"{drove}: no fallback")
    if not reached:
        found, advice = f"{drove}: the backup law braked in {braked:.0%} of the periods", EASIER
    else:
        first = min(reached, key=lambda end: end.after_s)
        found = f"{drove}: {len(reached)} of them into a fallback, first {first}"
        advice = f"{'' if core.design.gatekeeper else 'a gatekeeper, '}{EASIER}"
    return Finding(severity=Severity.WARNING, topic="rows", subject=SUBJECT, found=found, advice=advice)


def _energy(core: SafetyPassivityFilter, drives: Sequence[Drive], drove: str) -> Finding:
    """Return how often the passivity row was relaxed, and how low the tank got, which only slack takes below zero."""
    tank, dt_s = core.design.passivity.tank, core.design.dt_s
    relaxed = f"{drove}: the passivity row was relaxed in {_share(drives, Status.RELAXED):.0%} of the periods"
    if tank is None:
        return Finding(severity=Severity.NOTE, topic="energy", subject=SUBJECT, found=relaxed)
    least_j = min((level_j for each in drives for level_j in each.tank_j), default=tank.initial_j)
    found = f"{relaxed}, least energy in the tank {least_j:.3g} J"
    below = [k for each in drives for k, level_j in enumerate(each.tank_j) if level_j < -TANK_ROUNDING * tank.initial_j]
    if not below:
        return Finding(severity=Severity.NOTE, topic="energy", subject=SUBJECT, found=found)
    return Finding(
        severity=Severity.WARNING,
        topic="energy",
        subject=SUBJECT,
        found=f"{found}, below zero first after {(min(below) + 1) * dt_s:.3g} s",
        advice="safety or the limits need energy that the robot was not given: a larger tank, wider limits, "
        "or an output and a storage function with which the plant is passive",
    )


def _unsteady(core: SafetyPassivityFilter, drives: Sequence[Drive]) -> Iterator[Finding]:
    """Yield a finding if the law keeps every barrier from where it was sent, but not with inputs that are lost."""
    backed = [each.backed_x for each in drives if each.backed_x is not None]
    courses = FailSafeCourses(core)
    if any(courses.is_kept(x) and not courses.is_kept_late(x) for x in backed):
        yield Finding(
            severity=Severity.WARNING,
            topic="fail-safe",
            subject=SUBJECT,
            found=f"sent in {_share(drives, Status.BACKUP):.0%} of the periods, it {unsteady(core)}",
            advice=UNSTEADY,
        )


def _share(drives: Sequence[Drive], status: Status) -> float:
    return sum(each.statuses.count(status) for each in drives) / sum(len(each.statuses) for each in drives)
