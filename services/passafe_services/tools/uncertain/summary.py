"""The summary of an uncertain campaign: a line for each cell."""

from collections.abc import Sequence
from math import nan
from typing import Self

import numpy as np

from passafe_services.tools.runs.record import SweepRecord
from passafe_services.tools.uncertain.trials import UncertainTrial
from passafe_services.tools.uncertain.uncertain_result import UncertainResult


class TrialSummary(SweepRecord):
    """The summary of one cell.

    Attributes:
        scenario: Name.
        sets: Name of the sets.
        link: Name of the link.
        protection: Name of what protects.
        rollouts: How many.
        safe: Rollouts with h ≥ 0.
        h_worst: Smallest h of all.
        worst_seed: Seed that shows it.
        stand_off_m: Median distance from the boundary at the end of rollouts whose operator pushes in one direction and
            whose disturbance pushes against the barrier, m; NaN where there are none.
        guarded_share: Share of ticks in which the guard changed the input.
        fallback_share: Share of ticks in a fallback.
        is_promised: Whether h ≥ 0 is claimed.
    """

    scenario: str
    sets: str
    link: str
    protection: str
    rollouts: int
    safe: int
    h_worst: float
    worst_seed: int
    stand_off_m: float
    guarded_share: float
    fallback_share: float
    is_promised: bool

    @classmethod
    def of(cls, cell: UncertainTrial, results: Sequence[UncertainResult]) -> Self:
        """Summarise at least one result."""
        worst = min(results, key=lambda result: result.h_min)
        pushed = [r.gap_m for r in results if r.operator == "constant" and r.disturbance == "greedy"]
        return cls(
            scenario=cell.scenario,
            sets=cell.sets,
            link=cell.link,
            protection=cell.protection,
            rollouts=len(results),
            safe=sum(result.h_min >= 0.0 for result in results),
            h_worst=worst.h_min,
            worst_seed=worst.seed,
            stand_off_m=float(np.median(pushed)) if pushed else nan,
            guarded_share=sum(result.guarded_share for result in results) / len(results),
            fallback_share=sum(result.fallback_share for result in results) / len(results),
            is_promised=cell.is_promised,
        )

    @property
    def holds(self) -> bool:
        """True if h ≥ 0 in every rollout, or none was promised."""
        return not self.is_promised or self.safe == self.rollouts


class UncertainSummary(SweepRecord):
    """The summary of a campaign.

    Attributes:
        cells: In the order in which they ran.
    """

    cells: tuple[TrialSummary, ...]

    @property
    def holds(self) -> bool:
        """True if every cell keeps what it promises."""
        return all(cell.holds for cell in self.cells)
