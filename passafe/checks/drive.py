"""Operators at the limits of the input who drive a filtered robot from its start, its tank kept.

Some ask for the same corner of the limits all the time, as one who drives at a wall; others change it now and then.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from passafe.decision import Decision, Status
from passafe.design import FilterDesign
from passafe.limits import Limits
from passafe.sampled_plant import SampledPlant

CHANGES: Final = 0.05
"""Share of the periods at which every other one of them asks for something else."""


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


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """Outcome of one operator's drive.

    Attributes:
        statuses: Of all decisions.
        fallback: Fallback that ended it; ``None`` if none did.
        tank_j: Energy in the tank at the end of every period, J; of no meaning without a tank.
        backed_x: State in which the backup law's input was sent first, by its course; ``None`` if it never was.
    """

    statuses: list[Status] = field(default_factory=list)
    fallback: FallbackReached | None = None
    tank_j: list[float] = field(default_factory=list)
    backed_x: tuple[float, ...] | None = None


def drive(
    design: FilterDesign,
    decide: Callable[..., Decision],
    x0: Sequence[float],
    periods: int,
    seed: int,
    operator: int,
) -> Drive:
    """Return what comes of one operator's drive, until a fallback or its end.

    Args:
        design: The design of the filter.
        decide: Its ``SafetyPassivityFilter.decide``.
        x0: Start, n numbers.
        periods: How many it takes at most.
        seed: Seed of all operators.
        operator: Number of this one; those of odd numbers change what they ask for.

    Raises:
        IntegrationError: The plant cannot be followed.
    """
    tank = design.passivity.tank
    plant = SampledPlant(design.system, design.passivity.V, design.dt_s)
    requests = _requests(design.limits, np.random.default_rng([seed, operator]), changes=operator % 2 == 1)
    rest, statuses, levels = (0.0,) * design.system.m, list[Status](), list[float]()
    backed_x: tuple[float, ...] | None = None
    sample, u, level_j = plant.at(x0), design.limits.centre, design.passivity.initial_j
    for k in range(periods):
        t_s = k * design.dt_s
        decision = decide(sample.x, u, next(requests), rest, level_j, t_s, start=k == 0)
        statuses.append(decision.status)
        if decision.status.is_fallback:
            reached = FallbackReached(after_s=t_s, status=decision.status, x=sample.x)
            return Drive(statuses=statuses, fallback=reached, tank_j=levels, backed_x=backed_x)
        if decision.status is Status.BACKUP and backed_x is None:
            backed_x = sample.x
        after, u = plant.advance(sample.x, decision.u), decision.u
        if tank is not None:
            level_j = tank.balance(level_j, after.energy_in_j, after.stored_j - sample.stored_j)
        levels.append(level_j)
        sample = after
    return Drive(statuses=statuses, tank_j=levels, backed_x=backed_x)


def _requests(limits: Limits, rng: np.random.Generator, *, changes: bool) -> Iterator[list[float]]:
    """Yield what an operator asks for in period after period: a corner of the limits."""
    sides = np.array((limits.low, limits.high))
    corner = rng.permuted(sides, axis=0)[0]
    while True:
        if changes and rng.random() < CHANGES:
            corner = rng.permuted(sides, axis=0)[0]
        yield corner.tolist()
