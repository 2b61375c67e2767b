"""Seeded rollouts of one scenario, many in a batch."""

from collections.abc import Sequence
from itertools import groupby
from typing import Final

import numpy as np

from passafe.filter import SafetyPassivityFilter
from passafe_services.scenarios.design import design_of, robot_of, sampled_plant_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.adversaries import ADVERSARIES, AdversaryBatch
from passafe_services.tools.campaign.batch_loop import BatchLoop
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.campaign.safe_starts import SafeStarts

STREAM: Final = 0x9A55AFE
"""Second part of the seed of every rollout's generator."""


class Rollouts:
    """Runs rollouts of one scenario on one compiled filter. None depends on which others run beside it.

    Attributes:
        scenario: What is run.
    """

    def __init__(self, scenario: Scenario, *, scalar: bool = False) -> None:
        """Compile filter and plant.

        Args:
            scenario: What is run.
            scalar: Whether the filter takes every decision by itself, rather than in batches.
        """
        self.scenario = scenario
        robot = robot_of(scenario)
        self._core = SafetyPassivityFilter(design_of(scenario, robot))
        self._plant = sampled_plant_of(scenario, robot)
        self._starts = SafeStarts(scenario, self._core)
        self._scalar = scalar

    def run(self, seeds: Sequence[int], duration_s: float) -> list[RolloutResult]:
        """Return the results of a rollout for each seed, in their order.

        Args:
            seeds: Each decides a rollout's start and adversary.
            duration_s: Plant time, s.

        Raises:
            NoSafeStartError: A box of starts without a safe one.
        """
        names = list(ADVERSARIES)
        elements = sorted(seeds, key=lambda seed: seed % len(names))  # those with the same adversary side by side
        rngs = [np.random.default_rng([seed, STREAM]) for seed in elements]
        batches: list[tuple[slice, AdversaryBatch]] = []
        adversaries = [names[seed % len(names)] for seed in elements]
        for name, group in groupby(range(len(elements)), key=adversaries.__getitem__):
            members = list(group)
            where = slice(members[0], members[-1] + 1)
            batches.append((where, ADVERSARIES[name](rngs[where], self._core.design.system.m, where)))
        x = np.column_stack([self._starts.draw(rng) for rng in rngs])
        loop = BatchLoop(self.scenario, self._core, self._plant, batches, x)
        for _ in range(round(duration_s / self.scenario.dt_s)):
            loop.tick(scalar=self._scalar)
        results = dict(zip(elements, loop.results(elements, adversaries), strict=True))
        return [results[seed] for seed in seeds]
