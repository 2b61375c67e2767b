"""One seeded closed loop of filter and plant against an adversary, and the worst that happened in it."""

from collections import Counter
from typing import Final

import numpy as np
from pydantic import BaseModel, ConfigDict

from passafe.decision import Status
from passafe.filter import SafetyPassivityFilter
from passafe.workspace import Array
from services.campaign.adversaries import ADVERSARIES, Adversary
from services.campaign.starts import SafeStarts
from services.review.core_mathematics import CoreMathematics
from services.scenarios.design import design_of, robot_of, sampled_plant_of, tank_of
from services.scenarios.schema import Scenario

BETWEEN: Final = 4
"""Instants of every period at which h is looked at."""


class Outcome(BaseModel):
    """What one rollout came to.

    Attributes:
        seed: What it can be run again with.
        adversary: Who asked.
        h_min: Smallest barrier value, at and between samples.
        tank_min_j: Smallest energy in the tank, J.
        overreach: By how much an input was beyond its limits at most, units of u; 0 or less if none was.
        ticks: Decisions taken.
        statuses: How many of each.
        between_samples_unproven: Certified decisions without the margin of their own neighbourhood.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    seed: int
    adversary: str
    h_min: float
    tank_min_j: float
    overreach: float
    ticks: int
    statuses: dict[str, int]
    between_samples_unproven: int


class Rollouts:
    """Runs rollouts of one scenario, one after the other, on one derived filter.

    Attributes:
        scenario: What is run.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Derive filter, plant and mathematics."""
        self.scenario = scenario
        robot = robot_of(scenario)
        self._core = SafetyPassivityFilter(design_of(scenario, robot))
        self._plant = sampled_plant_of(scenario, robot)
        self._tank = tank_of(scenario)
        self._mathematics = CoreMathematics(scenario)
        self._starts = SafeStarts(scenario, self._core)
        self._n, self._m = robot.system.n, robot.system.m

    def run(self, seed: int, duration_s: float) -> Outcome:
        """Return the outcome of one rollout.

        Args:
            seed: Decides start and adversary.
            duration_s: Plant time, s.
        """
        rng = np.random.default_rng([seed, 0x9A55AFE])
        name = list(ADVERSARIES)[seed % len(ADVERSARIES)]
        return self._roll(seed, name, ADVERSARIES[name](rng, self._m), self._starts.draw(rng), duration_s)

    def _roll(self, seed: int, name: str, ask: Adversary, start: Array, duration_s: float) -> Outcome:
        dt_s, m = self.scenario.dt_s, self._m
        steps = round(duration_s / dt_s)
        xs, us = np.empty((self._n, steps)), np.empty((m, steps))
        statuses: Counter[Status] = Counter()
        unproven, decision = 0, None
        u: tuple[float, ...] = (0.0,) * m
        sample, level_j = self._plant.at(start.tolist()), self._tank.initial_j
        lowest_j, overreach, rate = level_j, -np.inf, (0.0,) * m
        for k in range(steps):
            u_h = ask(k * dt_s, decision).tolist()
            decision = self._core.decide(sample.x, u, u_h, rate, level_j, k * dt_s, start=k == 0)
            overreach = max(overreach, self._overreach(np.array(decision.u), np.array(u), first=k == 0))
            u = decision.u
            statuses[decision.status] += 1
            if not decision.status.is_fallback:
                unproven += bool(decision.part("shortfall")[0] > 0 or decision.part("strayed")[0] > 0)
            xs[:, k], us[:, k] = sample.x, u
            stored_j = sample.stored_j
            sample = self._plant.advance(sample.x, u)
            level_j = self._tank.balance(level_j, sample.energy_in_j, sample.stored_j - stored_j)
            lowest_j = min(lowest_j, level_j)
        return Outcome(
            seed=seed,
            adversary=name,
            h_min=self._lowest_h(xs, us),
            tank_min_j=lowest_j,
            overreach=float(overreach),
            ticks=steps,
            statuses={status.name: count for status, count in statuses.items()},
            between_samples_unproven=unproven,
        )

    def _overreach(self, after: Array, before: Array, *, first: bool) -> float:
        limits, dt_s = self._core.design.limits, self.scenario.dt_s
        worst = float((np.abs(after) - limits.magnitude).max())
        if limits.norm is not None:
            worst = max(worst, float(np.linalg.norm(after)) - limits.norm)
        if limits.rate_per_s is not None and not first:
            worst = max(worst, float((np.abs(after - before) - dt_s * np.array(limits.rate_per_s)).max()))
        return worst

    def _lowest_h(self, xs: Array, us: Array) -> float:
        if not self._core.chains:
            return float("inf")
        dt_s = self.scenario.dt_s
        t_s = np.arange(xs.shape[1], dtype=np.float64) * dt_s
        values = [self._mathematics.h(xs, t_s)]
        for j in range(1, BETWEEN + 1):
            offset_s = dt_s * j / BETWEEN
            values.append(self._mathematics.h(self._mathematics.flow(xs, us, offset_s), t_s + offset_s))
        return float(min(value.min() for value in values))
