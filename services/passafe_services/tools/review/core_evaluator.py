"""Evaluator of a scenario's functions for many samples, from the expressions of the core."""

from collections.abc import Sequence
from functools import cache

import casadi as ca

from passafe.batch.batch_function import BatchFunction
from passafe.passivity import power_margin
from passafe.sampled_plant import held_flow
from passafe.workspace import dense_function
from passafe_services.scenarios.design import barriers_of, robot_of, storage_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.plant_evaluator import FloatArray


class CoreEvaluator:
    """``PlantEvaluator`` of one scenario, derived from the same expressions as the filter's rows.

    ``flow`` is exact for linear plants. For others it takes one extrapolated Runge–Kutta step, as the plant does over a
    whole period, so its error over part of a period is below that of the plant.

    Args:
        scenario: The scenario.

    Raises:
        ScenarioError: The parameters or x0 do not fit the model.
    """

    def __init__(self, scenario: Scenario) -> None:
        robot = robot_of(scenario)
        self._system = system = robot.system
        h = ca.vertcat(ca.SX(0, 1), *(barrier.h for barrier in barriers_of(scenario, robot)))
        self._h = _evaluator("h", [system.x, system.t], h)
        margin = power_margin(system, storage_of(scenario, robot))
        self._margin = _evaluator("power_margin", [system.x, system.u], margin)
        self._flow = cache(self._derive_flow)

    def h(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return barrier values, shape (barriers, N), for x of shape (n, N) and plant time t_s, s, of shape (N,)."""
        return self._h(x, t_s.reshape(1, -1))[0]

    def power_margin(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return h_u(x, u), W, shape (N,), for x of shape (n, N) and u of shape (m, N)."""
        return self._margin(x, u)[0].reshape(-1)

    def flow(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return the state ``duration_s`` after x with u held, shape (n, N), for x (n, N) and u (m, N)."""
        return self._flow(duration_s)(x, u)[0]

    def _derive_flow(self, duration_s: float) -> BatchFunction:
        x_next, _, _ = held_flow(self._system, duration_s)
        return _evaluator("flow", [self._system.x, self._system.u], x_next)


def _evaluator(name: str, arguments: Sequence[ca.SX], result: ca.SX) -> BatchFunction:
    return BatchFunction(dense_function(name, arguments, [result]), by_casadi=True)
