"""The smallest barrier value at several instants of a period in which the input is held, for many plants at once."""

import casadi as ca
import numpy as np

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.numerics.workspace import Array, BlockLayout, dense_function
from passafe.sampled_plant import held_flow
from passafe_services.scenarios.design import barriers_of, robot_of
from passafe_services.scenarios.schema import Scenario

BETWEEN = 4
"""Instants of every period at which h is looked at."""


class LowestBarrier:
    """Evaluates h at the beginning of a period and at instants within it.

    A nonlinear plant is followed by one extrapolated Runge–Kutta step, as the plant's own over a whole period, so that
    its error over a part of one is below the plant's.
    """

    def __init__(self, scenario: Scenario, count: int) -> None:
        """Derive h along the flow.

        Args:
            scenario: Gives plant and barriers.
            count: How many plants.
        """
        robot = robot_of(scenario)
        system = robot.system
        barriers = barriers_of(scenario, robot)
        h = ca.vertcat(ca.SX(0, 1), *(barrier.h for barrier in barriers))
        at_instants = []
        for j in range(BETWEEN):
            offset_s = scenario.dt_s * j / BETWEEN
            x = system.x if j == 0 else held_flow(system, offset_s)[0]
            at_instants.append(ca.substitute(h, ca.vertcat(system.x, system.t), ca.vertcat(x, system.t + offset_s)))
        along = ca.vertcat(ca.SX(0, 1), *at_instants)
        names = {"x": system.n, "u": system.m, "t": 1, "h": along.numel()}
        self._workspace = BatchWorkspace(BlockLayout.of(names), count)
        function = dense_function("h", [system.x, system.u, system.t], [along])
        self._evaluate = self._workspace.bind(function, ["x", "u", "t"], ["h"])
        self._barriers = len(barriers)

    def during(self, x: Array, u: Array, t_s: float) -> Array:
        """Return the smallest h from t on, before the period is over, shape (count,); infinity without a barrier.

        Args:
            x: States at the beginning, shape (n, count).
            u: Inputs held over the period, shape (m, count).
            t_s: Plant time at the beginning, s.
        """
        lowest: Array = self._h(x, u, t_s).min(axis=0, initial=np.inf)
        return lowest

    def at(self, x: Array, t_s: float) -> Array:
        """Return the smallest h at one instant, shape (count,); infinity without a barrier.

        Args:
            x: States, shape (n, count).
            t_s: Plant time, s.
        """
        lowest: Array = self._h(x, 0.0, t_s)[: self._barriers].min(axis=0, initial=np.inf)
        return lowest

    def _h(self, x: Array, u: Array | float, t_s: float) -> Array:
        workspace = self._workspace
        for name, value in (("x", x), ("u", u), ("t", t_s)):
            workspace.part(name)[:, : workspace.used] = value
        self._evaluate()
        return workspace.part("h")[:, : workspace.used]
