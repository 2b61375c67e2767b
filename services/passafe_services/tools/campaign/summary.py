"""What a campaign came to: the worst of everything, with the seed that shows it."""

from collections import Counter
from collections.abc import Sequence
from typing import Self

from pydantic import BaseModel, ConfigDict

from passafe_services.tools.campaign.rollout_result import RolloutResult

ROUNDING = 1e-12
"""By how much an input may be beyond its limits through rounding, units of u."""


class WorstCase(BaseModel):
    """A worst value and the rollout in which it was taken."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    value: float
    seed: int
    adversary: str


class CampaignSummary(BaseModel):
    """What a campaign of one scenario came to.

    Attributes:
        scenario: Name.
        rollouts: How many.
        ticks: Decisions in all of them.
        h_min: Smallest barrier value, at and between samples.
        tank_min_j: Smallest energy in the tank, J.
        overreach: By how much an input was beyond its limits at most, units of u.
        statuses: How many ticks of each.
        rollouts_with: How many rollouts have at least one tick of each status.
        unsafe: Rollouts with h < 0.
        drained: Rollouts with a tank below zero.
        between_samples_unproven: Certified ticks without their margin between samples.
        decided_singly: Ticks that the filter took one by one; the others were decided in batches.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenario: str
    rollouts: int
    ticks: int
    h_min: WorstCase
    tank_min_j: WorstCase
    overreach: WorstCase
    statuses: dict[str, int]
    rollouts_with: dict[str, int]
    unsafe: int
    drained: int
    between_samples_unproven: int
    decided_singly: int

    @classmethod
    def of(cls, scenario: str, outcomes: Sequence[RolloutResult]) -> Self:
        """Sum up at least one outcome."""
        statuses: Counter[str] = Counter()
        rollouts_with: Counter[str] = Counter()
        for outcome in outcomes:
            statuses.update(outcome.statuses)
            rollouts_with.update(outcome.statuses.keys())
        return cls(
            scenario=scenario,
            rollouts=len(outcomes),
            ticks=sum(outcome.ticks for outcome in outcomes),
            h_min=_worst(outcomes, [outcome.h_min for outcome in outcomes]),
            tank_min_j=_worst(outcomes, [outcome.tank_min_j for outcome in outcomes]),
            overreach=_worst(outcomes, [-outcome.overreach for outcome in outcomes], sign=-1.0),
            statuses=dict(statuses),
            rollouts_with=dict(rollouts_with),
            unsafe=sum(not outcome.h_min >= 0 for outcome in outcomes),
            drained=sum(not outcome.tank_min_j >= 0 for outcome in outcomes),
            between_samples_unproven=sum(outcome.between_samples_unproven for outcome in outcomes),
            decided_singly=sum(outcome.decided_singly for outcome in outcomes),
        )

    @property
    def holds(self) -> bool:
        """Whether every rollout stayed safe, solvent, within the limits and certified."""
        return self.unsafe == self.drained == self.between_samples_unproven == 0 and self.overreach.value <= ROUNDING


def _worst(outcomes: Sequence[RolloutResult], values: Sequence[float], sign: float = 1.0) -> WorstCase:
    value, where = min((value, k) for k, value in enumerate(values))
    return WorstCase(value=sign * value, seed=outcomes[where].seed, adversary=outcomes[where].adversary)
