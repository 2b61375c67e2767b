"""The rollouts of one campaign, as workers and the results file see them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, Self

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.rollout import Rollouts
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.runs.results_file import ResultsFile, ResultsHeading

BATCH: Final = 1000
"""Rollouts in one batch, at most: with more an operation costs each of them hardly less, and results come later."""

BATCH_SCALAR: Final = 16
"""The same where the filter takes every decision by itself."""


@dataclass(frozen=True, kw_only=True, slots=True)
class CampaignJob:
    """All that the rollouts of a campaign have in common; a task is a seed.

    Attributes:
        scenario_json: What is run.
        duration_s: Plant time of each rollout, s.
        scalar: Whether the filter takes every decision by itself, rather than in batches.
    """

    scenario_json: str
    duration_s: float
    scalar: bool = False

    @classmethod
    def of(cls, scenario: Scenario, duration_s: float, *, scalar: bool = False) -> Self:
        """Return the job of a campaign."""
        return cls(scenario_json=scenario.model_dump_json(), duration_s=duration_s, scalar=scalar)

    def compile(self) -> Callable[[Sequence[int]], list[RolloutResult]]:
        """Return the function from seeds to the results of their rollouts."""
        scenario = Scenario.model_validate_json(self.scenario_json)
        return partial(Rollouts(scenario, scalar=self.scalar).run, duration_s=self.duration_s)

    def batch_size(self, seeds: int, workers: int) -> int:
        """Return how many rollouts a batch has: as many for one worker as for another, if possible.

        Args:
            seeds: How many rollouts there are.
            workers: How many workers.
        """
        rounds = -(-seeds // ((BATCH_SCALAR if self.scalar else BATCH) * workers))
        return -(-seeds // max(rounds * workers, 1))


def campaign_results(path: Path, scenario: Scenario, duration_s: float) -> ResultsFile[int, RolloutResult]:
    """Open the results file of a campaign, or begin it.

    Raises:
        ResultsFileError: It holds results of something else, or no results.
    """
    subject = {"scenario": scenario.model_dump(mode="json"), "duration_s": duration_s}
    return ResultsFile(path, ResultsHeading.of("campaign", subject), RolloutResult, lambda result: result.seed)
