"""Closed loops over a delayed link with plants that are members of the sets, in a batch."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import casadi as ca
import numpy as np

from passafe.batch.batch_filter import BatchFilter
from passafe.decision import FALLBACKS, Status
from passafe.design import FilterDesign
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array
from passafe.state_set import ErrorGrowth
from passafe.uncertainty import Uncertainty
from passafe_services.tools.uncertain.adversaries import Adversaries
from passafe_services.tools.uncertain.delayed_states import DelayedStates
from passafe_services.tools.uncertain.trials import LINKS, SETS, UncertainTrial
from passafe_services.tools.uncertain.true_plants import LowestLevel, TruePlants
from passafe_services.tools.uncertain.uncertain_result import UncertainResult

FOLLOWS: Final = 0.999
"""k_i·dt of the guard: the share of the way to the filter's input that it goes in one period."""

ALIKE: Final = 1e-5
"""Rows whose margins differ by no more are equally tight, units of u."""


class CompiledTrial:
    """Filter, guard and growth of the error of one cell."""

    def __init__(self, cell: UncertainTrial, design: FilterDesign) -> None:
        """Derive what the cell needs.

        Args:
            cell: The combination.
            design: For the model alone, in mode safe.
        """
        self.cell, self.sets = cell, SETS[cell.sets]
        robust = replace(design, uncertainty=self.sets)
        self.design = robust
        self.growth = ErrorGrowth(robust)
        # Empty sets: the model's rows, without the courses that are compared outside of the protected set.
        self.core = SafetyPassivityFilter(
            robust if cell.has_robust_filter else replace(design, uncertainty=Uncertainty())
        )
        self.guard = None
        if cell.has_guard:
            no_feedback = ca.SX.zeros(design.system.m)
            self.guard = SafetyPassivityFilter(replace(robust, u_fb=no_feedback, k_i=FOLLOWS / design.dt_s))

    def run(self, seeds: Sequence[int], rngs: Sequence[np.random.Generator], x: Array, ticks: int) -> "UncertainLoop":
        """Return the loop of some rollouts after so many ticks.

        Args:
            seeds: Of the rollouts.
            rngs: A generator for each.
            x: True states at the start, shape (n, count).
            ticks: How many.
        """
        loop = UncertainLoop(self, seeds, rngs, x, ticks)
        for _ in range(ticks):
            loop.tick()
        return loop


class UncertainLoop:
    """A batch of loops of one cell."""

    def __init__(
        self, compiled: CompiledTrial, seeds: Sequence[int], rngs: Sequence[np.random.Generator], x: Array, ticks: int
    ) -> None:
        """Put every plant where it starts; see ``CompiledTrial.run``."""
        design, cell, count = compiled.design, compiled.cell, x.shape[1]
        self._compiled, self._rngs, self._seeds, self._count = compiled, rngs, seeds, count
        self._plants = TruePlants(design, _members(design, compiled.sets, rngs))
        levels = {chain.barrier.name.partition("[mass")[0]: chain.psi[-2] for chain in compiled.core.chains}
        self._lowest = LowestLevel(design, ca.vertcat(*levels.values()), count)
        bounds = np.array(compiled.sets.disturbance or (0.0,) * design.system.n)
        self._adversaries = Adversaries(seeds, rngs, x, bounds)
        self._states = DelayedStates(LINKS[cell.link], compiled.growth, ticks, rngs, design.dt_s)
        self._fresh = DelayedStates(LINKS["none"], compiled.growth, ticks, rngs, design.dt_s)
        self._filter = BatchFilter(compiled.core, count)
        self._guard = None if compiled.guard is None else BatchFilter(compiled.guard, count)
        self._x, self._u, self._applied = x, np.zeros((design.system.m, count)), np.zeros((design.system.m, count))
        self._h_min, self._ticks = np.full(count, np.inf), 0
        self._guarded, self._fallbacks = np.zeros(count), np.zeros(count)
        self._widest = np.zeros_like(x)

    def tick(self) -> None:
        """Measure, decide for the plant time that is next, guard, disturb and advance by one period."""
        is_first, t_s = self._ticks == 0, self._ticks * self._compiled.design.dt_s
        measured = self._x + self._noise()
        self._states.measure(measured)
        predicted, error = self._states.predicted()
        self._widest = np.maximum(self._widest, error)
        u_h = self._adversaries.ask(t_s, self._into_rows(is_first=is_first))
        x_error = error if self._compiled.cell.has_robust_filter else None
        self._filter.decide(predicted, self._u, u_h, 0.0, 0.0, t_s, x_error, start=is_first)
        self._u = self._filter.evaluation.u_plus[:, : self._count].copy()
        last = self._filter
        if self._guard is None:
            self._applied = self._u
        else:
            last = self._guard
            self._fresh.measure(measured)
            fresh, fresh_error = self._fresh.predicted()
            # As if it had been in force already: then margins are those about it, as in the plant's guard.
            self._guard.decide(fresh, self._u, self._u, 0.0, 0.0, t_s, fresh_error, start=is_first)
            self._applied = self._guard.evaluation.u_plus[:, : self._count].copy()
            self._fresh.send(self._applied, self._applied)
            self._guarded += last.status[: self._count] != Status.PASSED
        self._states.send(self._u, self._applied)
        self._fallbacks += np.isin(last.status[: self._count], [*FALLBACKS])
        push = self._adversaries.push(t_s, self._x, self._lowest)
        self._x, h = self._plants.advance(self._x, self._applied, push)
        self._h_min = np.minimum(self._h_min, h)
        self._ticks += 1

    def results(self) -> list[UncertainResult]:
        """Return the result of every rollout."""
        gap = self._lowest.gap(self._x)
        return [
            UncertainResult(
                seed=seed,
                operator=self._adversaries.operators[i],
                disturbance=self._adversaries.disturbances[i],
                h_min=float(self._h_min[i]),
                gap_m=float(gap[i]),
                guarded_share=float(self._guarded[i] / self._ticks),
                fallback_share=float(self._fallbacks[i] / self._ticks),
                x_error_max=tuple(self._widest[:, i].tolist()),
            )
            for i, seed in enumerate(self._seeds)
        ]

    def _noise(self) -> Array:
        """Return measurement errors: half of the rollouts at the corners of the box, half anywhere in it."""
        bounds = np.array(self._compiled.growth.at_measurement)
        if not bounds.any():
            return np.zeros_like(self._x)
        drawn = np.array([rng.uniform(-1.0, 1.0, len(bounds)) for rng in self._rngs]).T
        at_corner = np.array([seed % 2 == 0 for seed in self._seeds])
        return bounds[:, None] * np.where(at_corner, np.sign(drawn), drawn)

    def _into_rows(self, *, is_first: bool) -> Array:
        """Return unit directions against the tightest hard row of the decision before, shape (m, count)."""
        if is_first:
            return np.zeros_like(self._u)
        decided, elements = self._filter, np.arange(self._count)
        margins = decided.evaluation.margins[: decided.hard, : self._count]
        tightest = (margins <= margins.min(axis=0) + ALIKE).argmax(axis=0)
        row = decided.gradients[:, tightest, elements]
        return np.asarray(-row / np.maximum(np.linalg.norm(row, axis=0), 1e-12))


def _members(design: FilterDesign, sets: Uncertainty, rngs: Sequence[np.random.Generator]) -> Array:
    """Return parameters of every plant: half of them at ends of their intervals, half anywhere between."""
    intervals = [sets.parameters.get(each.name, (each.value,) * 2) for each in design.system.parameters]
    low, high = np.array(intervals).T
    shares = [rng.uniform(size=len(low)) if rng.uniform() < 1 / 2 else rng.integers(0, 2, len(low)) for rng in rngs]
    return np.asarray(low[:, None] + (high - low)[:, None] * np.array(shares).T)
