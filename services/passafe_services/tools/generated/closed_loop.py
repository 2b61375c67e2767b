"""The closed loop of a filter and a plant, and what braking alone would have done in its place."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import casadi as ca
import numpy as np

from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array
from passafe_services.tools.generated.dense_flow import DenseFlow
from passafe_services.tools.generated.generated_design import GeneratedDesign
from passafe_services.tools.generated.loop_plan import LoopPlan
from passafe_services.tools.generated.nearest_input import nearest_input
from passafe_services.tools.generated.watch import Lowest, Watch

FAR: Final = 1e3
"""A loop ends where a state is further from the box of its plant than so many times the box's width."""


@dataclass(slots=True)
class LoopTrace:
    """A loop, tick by tick.

    Attributes:
        states: x at the beginning of every period.
        before: Input in force until then.
        statuses: Of the decisions.
        lowest: Least values of every period.
        accounted_j: Tank at the end of every period and all slack so far, J.
        overreach: Largest share by which an input was beyond a limit.
    """

    states: list[Array] = field(default_factory=list)
    before: list[Array] = field(default_factory=list)
    statuses: list[Status] = field(default_factory=list)
    lowest: list[Lowest] = field(default_factory=list)
    accounted_j: list[float] = field(default_factory=list)
    overreach: float = -1.0

    def add(self, x: Array, before: Array, status: Status, lowest: Lowest) -> None:
        """Add one period."""
        self.states.append(x)
        self.before.append(before)
        self.statuses.append(status)
        self.lowest.append(lowest)

    def h(self, first: int = 0) -> Array:
        """Return the least h of every period from one on."""
        return np.array([lowest.h for lowest in self.lowest[first:]])

    def entries(self) -> list[int]:
        """Return the ticks at which a fallback began."""
        falls = [status.is_fallback for status in self.statuses]
        return [k for k, fell in enumerate(falls) if fell and not (k and falls[k - 1])]


class ClosedLoop:
    """Runs loops of one design.

    Attributes:
        core: Its filter.
    """

    def __init__(self, design: GeneratedDesign, core: SafetyPassivityFilter) -> None:
        """Compile the plant.

        Args:
            design: What is run.
            core: Its filter.
        """
        plant = design.plant
        self._design, self.core = design, core
        self._dt_s = design.timing.dt_s
        self._flow, self._watch = DenseFlow(plant.system, self._dt_s), Watch(design)
        self._fail_safe = ca.Function("fail_safe", [plant.system.x], [ca.densify(plant.fail_safe)])
        low, high = np.array(plant.low), np.array(plant.high)
        self._middle, self._furthest = (low + high) / 2, FAR * (high - low)

    def run(self, plan: LoopPlan, most_fallbacks: int | None = None) -> LoopTrace:
        """Return what happens when the filter decides.

        Args:
            plan: The loop.
            most_fallbacks: Ticks in a fallback after which the loop ends; ``None`` for no limit.
        """
        trace, m = LoopTrace(), self._design.plant.system.m
        zero, slack_w, lost_j = np.zeros(m), 0.0, 0.0
        level_j = self._design.tank.initial_j if self._design.tank else 0.0
        x, before, fallbacks = plan.x, zero, 0
        for k, arrives in enumerate(plan.arrives.tolist()):
            if not self._is_near(x) or (most_fallbacks is not None and fallbacks >= most_fallbacks):
                break
            decision = self._decide(k, x, before, plan, level_j)
            u = np.array(decision.u)
            reached = self._design.limits.overreach(u, before if k else None, self._dt_s)
            trace.overreach = max(trace.overreach, reached if np.isfinite(u).all() else np.inf)
            applied, granted_w = (u, decision.slack) if arrives else (before, slack_w)
            after, lowest = self._advance(k, x, applied, level_j)
            if not np.isfinite(after).all():
                break  # at a singular point of the model there is nothing to judge
            trace.add(x, before, decision.status, lowest)
            fallbacks += decision.status.is_fallback
            x, before, slack_w = after, applied, granted_w
            level_j, lost_j = lowest.level_j, lost_j + slack_w * self._dt_s
            trace.accounted_j.append(lowest.tank_j + lost_j)
        return trace

    def brake(self, plan: LoopPlan, trace: LoopTrace, first: int) -> Array:
        """Return the least h of every period from tick ``first`` on, if nothing but the fail-safe law acted.

        Args:
            plan: The loop; the same inputs are lost.
            trace: What the filter did.
            first: Tick from whose state on the law acts.
        """
        return self._follow(lambda x: self._fail_safe(x).full().ravel(), plan, trace, first)

    def _follow(self, law: Callable[[Array], Array], plan: LoopPlan, trace: LoopTrace, first: int) -> Array:
        x, before, lowest_h = trace.states[first], trace.before[first], []
        for k in range(first, len(trace.states)):
            if not self._is_near(x):
                lowest_h.append(-np.inf)
                break
            if plan.arrives[k]:
                before = nearest_input(law(x), before if k else None, self._design.limits, self._dt_s)
            x, lowest = self._advance(k, x, before, 0.0)
            lowest_h.append(lowest.h)
        return np.array(lowest_h)

    def _decide(self, k: int, x: Array, before: Array, plan: LoopPlan, level_j: float) -> Decision:
        u_h, rate = plan.operator(k, x)
        state, in_force = x.tolist(), before.tolist()
        return self.core.decide(state, in_force, u_h.tolist(), rate.tolist(), level_j, k * self._dt_s, start=k == 0)

    def _advance(self, k: int, x: Array, u: Array, level_j: float) -> tuple[Array, Lowest]:
        period = self._flow.over(x, u)
        return period.states[:, -1].copy(), self._watch.during(period, u, k * self._dt_s, level_j)

    def _is_near(self, x: Array) -> bool:
        return bool((np.abs(x - self._middle) <= self._furthest).all())
