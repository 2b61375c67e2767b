"""The time that decisions take on this machine, against the period that they have."""

from collections.abc import Callable, Sequence
from time import process_time
from typing import Final

import numpy as np

from passafe.checks.drive import drive
from passafe.decision import Decision
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity

OPERATORS: Final = 2
"""Operators who drive from the start: one asks for the same corner of the limits all the time, one changes it."""

PERIODS: Final = 400
"""Periods that each drives at most."""

MOST: Final = 0.99
"""Share of the decisions that are to be made within the period."""


def decision_time_finding(
    core: SafetyPassivityFilter, x0: Sequence[float], seed: int, clock: Callable[[], float] = process_time
) -> Finding:
    """Return how long decisions take while operators drive from the start, and whether that fits into the period.

    Args:
        core: The filter.
        x0: Start, n numbers.
        seed: Seed of the operators.
        clock: Returns the processor time of this process, s.
    """
    times_s: list[float] = []

    def decide(*arguments: object, **options: object) -> Decision:
        began_s = clock()
        decision = core.decide(*arguments, **options)  # type: ignore[arg-type]  # passed on as they are
        times_s.append(clock() - began_s)
        return decision

    drive(core.design, core.decide, x0, 1, seed, 0)  # the first decision finds cold caches
    for operator in range(OPERATORS):
        drive(core.design, decide, x0, PERIODS, seed, operator)
    most_s, longest_s = float(np.quantile(times_s, MOST)), max(times_s)
    period_s = core.design.dt_s
    found = (
        f"{MOST:.0%} of {len(times_s)} decisions take up to {1e3 * most_s:.3g} ms of this processor, the longest "
        f"{1e3 * longest_s:.3g} ms; the period has {1e3 * period_s:.3g} ms"
    )
    if most_s <= period_s:
        return Finding(severity=Severity.NOTE, topic="loop rate", subject="decisions", found=found)
    return Finding(
        severity=Severity.WARNING,
        topic="loop rate",
        subject="decisions",
        found=found,
        advice="a lower rate, fewer rows or a faster processor: ticks will be missed, and inputs be held meanwhile",
    )
