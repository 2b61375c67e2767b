"""The summary of a campaign: spread and worst of every metric, with the seed that shows it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final, Self

from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.runs.record import SweepRecord
from passafe_services.tools.runs.summary import Spread, badness

ROUNDING = 1e-12
"""By how much an input may be beyond its limits through rounding, units of u."""

HIGH_IS_WORSE: Final[Mapping[str, bool]] = {"h_min": False, "tank_min_j": False, "overreach": True}
"""The metrics of a rollout, and whether large values are bad."""


class WorstRollout(SweepRecord):
    """The worst value of a metric and the rollout that shows it."""

    value: float
    seed: int
    adversary: str


class CampaignSummary(SweepRecord):
    """The summary of a campaign of one scenario.

    Attributes:
        scenario: Name.
        rollouts: How many.
        ticks: Decisions in all of them.
        metrics: Spread of ``h_min``, ``tank_min_j`` and ``overreach`` over the rollouts.
        worst: The worst rollout by each of them.
        statuses: How many ticks of each.
        rollouts_with: How many rollouts have at least one tick of each status.
        unsafe: Rollouts with h < 0.
        drained: Rollouts with a tank below zero.
        between_samples_unproven: Certified ticks without their margin between samples.
        decided_scalar: Ticks that the filter decided by itself; the others were decided in batches.
    """

    scenario: str
    rollouts: int
    ticks: int
    metrics: dict[str, Spread]
    worst: dict[str, WorstRollout]
    statuses: dict[str, int]
    rollouts_with: dict[str, int]
    unsafe: int
    drained: int
    between_samples_unproven: int
    decided_scalar: int

    @classmethod
    def of(cls, scenario: str, results: Sequence[RolloutResult]) -> Self:
        """Summarise at least one result."""
        statuses: Counter[str] = Counter()
        rollouts_with: Counter[str] = Counter()
        for result in results:
            statuses.update(result.statuses)
            rollouts_with.update(result.statuses.keys())
        spreads = {name: Spread.of(getattr(result, name) for result in results) for name in HIGH_IS_WORSE}
        return cls(
            scenario=scenario,
            rollouts=len(results),
            ticks=sum(result.ticks for result in results),
            metrics={name: spread for name, spread in spreads.items() if spread is not None},
            worst={name: _worst(results, name) for name in HIGH_IS_WORSE},
            statuses=dict(statuses),
            rollouts_with=dict(rollouts_with),
            unsafe=sum(not result.h_min >= 0 for result in results),
            drained=sum(not result.tank_min_j >= 0 for result in results),
            between_samples_unproven=sum(result.between_samples_unproven for result in results),
            decided_scalar=sum(result.decided_scalar for result in results),
        )

    @property
    def holds(self) -> bool:
        """True if every rollout stayed safe, solvent, within the limits and certified."""
        is_kept = self.unsafe == self.drained == self.between_samples_unproven == 0
        return is_kept and self.worst["overreach"].value <= ROUNDING


def _worst(results: Sequence[RolloutResult], name: str) -> WorstRollout:
    high = HIGH_IS_WORSE[name]
    worst = max(results, key=lambda result: badness(getattr(result, name), high_is_worse=high))
    return WorstRollout(value=getattr(worst, name), seed=worst.seed, adversary=worst.adversary)
