"""The rollouts of one cell, as workers and the results file see them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from passafe.filter import SafetyPassivityFilter
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.campaign.safe_starts import SafeStarts
from passafe_services.tools.runs.results_file import ResultsFile, ResultsHeading
from passafe_services.tools.uncertain.trials import SETS, UncertainTrial
from passafe_services.tools.uncertain.uncertain_loop import CompiledTrial
from passafe_services.tools.uncertain.uncertain_result import UncertainResult

RATE_HZ: Final = 250.0
"""Rate of filter and plant: a long one for what may happen within a period, and short enough for thousands of runs."""

STREAM: Final = 0x5E75
"""Second part of the seed of every rollout's generator."""

BATCH: Final = 500
"""Rollouts in one batch, at most."""


@dataclass(frozen=True, kw_only=True, slots=True)
class UncertainJob:
    """All that the rollouts of a cell have in common; a task is a seed.

    Attributes:
        cell: The combination.
        duration_s: Plant time of each rollout, s.
    """

    cell: UncertainTrial
    duration_s: float

    def compile(self) -> Callable[[Sequence[int]], list[UncertainResult]]:
        """Return the function from seeds to the results of their rollouts."""
        scenario = load_scenario(
            self.cell.scenario, {"filter.mode": "safe", "rate_hz": RATE_HZ, "filter.start": "nearest"}
        )
        design = design_of(scenario, robot_of(scenario))
        compiled = CompiledTrial(self.cell, design)
        robust = SafetyPassivityFilter(replace(design, uncertainty=SETS[self.cell.sets]))
        starts = SafeStarts(scenario, robust)

        def run(seeds: Sequence[int]) -> list[UncertainResult]:
            rngs = [np.random.default_rng([seed, STREAM]) for seed in seeds]
            x = np.column_stack([starts.draw(rng) for rng in rngs])
            ticks = round(self.duration_s * RATE_HZ)
            return compiled.run(seeds, rngs, x, ticks).results()

        return run

    def batch_size(self, seeds: int, workers: int) -> int:
        """Return how many rollouts a batch has.

        Args:
            seeds: How many rollouts there are.
            workers: How many workers.
        """
        return min(BATCH, -(-seeds // workers))


def uncertain_results(folder: Path, job: UncertainJob) -> ResultsFile[int, UncertainResult]:
    """Open the results file of a cell, or begin it.

    Raises:
        ResultsFileError: It holds results of something else, or no results.
    """
    subject = {"cell": job.cell.name, "duration_s": job.duration_s, "rate_hz": RATE_HZ}
    heading = ResultsHeading.of("uncertain campaign", subject)
    return ResultsFile(folder / f"{job.cell.name}.jsonl", heading, UncertainResult, lambda result: result.seed)
