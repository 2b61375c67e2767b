"""Closed loops of filter and plant that advance together, tick by tick, and the worst of each so far."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from passafe.batch.batch_filter import BatchFilter
from passafe.batch.batch_plant import BatchPlant
from passafe.decision import ANSWERS, Status
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array
from passafe.sampled_plant import SampledPlant
from passafe_services.scenarios.design import tank_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.adversaries import AdversaryBatch
from passafe_services.tools.campaign.lowest_barrier import LowestBarrier
from passafe_services.tools.campaign.rollout_result import RolloutResult


class BatchLoop:
    """A batch of loops of one scenario. No element's numbers depend on the others'."""

    def __init__(
        self,
        scenario: Scenario,
        core: SafetyPassivityFilter,
        plant: SampledPlant,
        adversaries: Sequence[tuple[slice, AdversaryBatch]],
        x: Array,
    ) -> None:
        """Put every plant where it starts.

        Args:
            scenario: What is run.
            core: Its filter.
            plant: Its plant.
            adversaries: Who asks for the inputs of which elements.
            x: Starts, shape (n, count).
        """
        count, m = x.shape[1], core.design.system.m
        self._dt_s, self._limits, self._tank = scenario.dt_s, core.design.limits, tank_of(scenario)
        self._adversaries, self._count, self._ticks = adversaries, count, 0
        self._decided, self._plants = BatchFilter(core, count), BatchPlant(plant, count)
        self._barriers = LowestBarrier(scenario, count)
        self._x, self._u, self._u_h = x, np.zeros((m, count)), np.zeros((m, count))
        self._stored_j = np.array([plant.at(start.tolist()).stored_j for start in x.T])
        self._level_j = np.full(count, self._tank.initial_j)
        self._h_min, self._tank_min_j = np.full(count, np.inf), self._level_j
        self._overreach = np.full(count, -np.inf)
        self._statuses: NDArray[np.int64] = np.zeros((max(Status) + 1, count), dtype=np.int64)
        self._unproven: NDArray[np.int64] = np.zeros(count, dtype=np.int64)
        self._scalar: NDArray[np.int64] = np.zeros(count, dtype=np.int64)

    def tick(self, *, scalar: bool = False) -> None:
        """Ask every operator, decide, and advance every plant by one period.

        Args:
            scalar: Whether the filter takes the decisions by itself, rather than in a batch.
        """
        t_s, first = self._ticks * self._dt_s, self._ticks == 0
        decided, plants, count = self._decided, self._plants.batch, self._count
        for elements, ask in self._adversaries:
            self._u_h[:, elements] = ask(t_s, None if first else decided)
        decided.decide(self._x, self._u, self._u_h, 0.0, self._level_j, t_s, start=first, scalar=scalar)
        u = decided.evaluation.u_plus[:, :count].copy()
        self._overreach = np.maximum(self._overreach, self._beyond_limits(u, first=first))
        self._count_decisions()
        self._h_min = np.minimum(self._h_min, self._barriers.during(self._x, u, t_s))
        self._plants.advance(self._x, u)
        stored_j, energy_in_j = plants.part("stored")[0, :count].copy(), plants.part("energy")[0, :count]
        self._level_j = self._tank.balance_many(self._level_j, energy_in_j, stored_j - self._stored_j)
        self._tank_min_j = np.minimum(self._tank_min_j, self._level_j)
        self._x, self._u, self._stored_j = plants.part("x_next")[:, :count].copy(), u, stored_j
        self._ticks += 1

    def results(self, seeds: Sequence[int], adversaries: Sequence[str]) -> Iterator[RolloutResult]:
        """Yield the result of every element.

        Args:
            seeds: Of each element.
            adversaries: Names, of each element.
        """
        h_min = np.minimum(self._h_min, self._barriers.at(self._x, self._ticks * self._dt_s))
        for element, (seed, adversary) in enumerate(zip(seeds, adversaries, strict=True)):
            yield RolloutResult(
                seed=seed,
                adversary=adversary,
                h_min=float(h_min[element]),
                tank_min_j=float(self._tank_min_j[element]),
                overreach=float(self._overreach[element]),
                ticks=self._ticks,
                statuses={status.name: n for status in Status if (n := int(self._statuses[status, element]))},
                between_samples_unproven=int(self._unproven[element]),
                decided_scalar=int(self._scalar[element]),
            )

    def _count_decisions(self) -> None:
        decided, elements = self._decided, np.arange(self._count)
        status = decided.status[: self._count]
        self._statuses[status, elements] += 1
        missing = (decided.assessment.shortfall[0] > 0) | (decided.assessment.outside_trust_region[0] > 0)
        self._unproven += missing[: self._count] & np.isin(status, ANSWERS)
        self._scalar += decided.scalar[: self._count]

    def _beyond_limits(self, after: Array, *, first: bool) -> Array:
        """Return by how much inputs are beyond their limits, shape (count,)."""
        return self._limits.excess(after, None if first else self._u, self._dt_s)
