"""Evaluator of a scenario's functions for many samples, from the expressions of the core."""

from collections.abc import Sequence
from functools import cache

import casadi as ca
import numpy as np

from passafe.barrier_chain import Barrier, derive_chains
from passafe.batch.batch_function import BatchFunction
from passafe.numerics.workspace import dense_function
from passafe.passivity import power_margin
from passafe.sampled_plant import LOCAL_TOLERANCE, held_flow
from passafe.system import System
from passafe_services.scenarios.design import barriers_of, robot_of, storage_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.rounding_error import rounding_error


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
        barriers = barriers_of(scenario, robot)
        h = ca.vertcat(ca.SX(0, 1), *(barrier.h for barrier in barriers))
        self._h = _evaluator("h", [system.x, system.t], h)
        self._h_error = cache(lambda: _h_error(system, h))
        self._levels = cache(lambda: _protected_levels(system, barriers))
        self._V = storage_of(scenario, robot)
        margin = power_margin(system, self._V)
        self._margin = _evaluator("power_margin", [system.x, system.u], margin)
        self._flow, self._flow_error = cache(self._derive_flow), cache(self._derive_flow_error)
        self._energy_gain = cache(self._derive_energy_gain)
        self._output = cache(lambda: _evaluator("output", [system.x], system.y))
        self._stored = cache(lambda: _evaluator("stored", [system.x], self._V))
        self._supplied = cache(self._derive_supplied)

    def h(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return barrier values, shape (barriers, N), for x of shape (n, N) and plant time t_s, s, of shape (N,)."""
        return self._h(x, t_s.reshape(1, -1))[0]

    def h_error(self, x: FloatArray, t_s: FloatArray, x_error: FloatArray) -> FloatArray:
        """Return bounds of the error of ``h``, shape (barriers, N); see ``rounding_error``.

        Args:
            x: States, shape (n, N).
            t_s: Plant times, s, shape (N,).
            x_error: By how much each number of a state may be wrong, shape (N,), or (n, N).
        """
        errors = np.ascontiguousarray(np.broadcast_to(x_error, x.shape))
        return np.nan_to_num(self._h_error()(x, t_s.reshape(1, -1), errors)[0], nan=0.0, posinf=0.0)

    @property
    def protected(self) -> Sequence[str]:
        """Names of the values of ``psi``."""
        return tuple(self._levels())

    def psi(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return ψ₀ … ψ_{r−1} of every barrier, shape (P, N), for x of shape (n, N) and t_s of shape (N,)."""
        levels = self._levels().values()
        evaluate = _evaluator("psi", [self._system.x, self._system.t], ca.vertcat(ca.SX(0, 1), *levels))
        return evaluate(x, t_s.reshape(1, -1))[0]

    def power_margin(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return h_u(x, u), W, shape (N,), for x of shape (n, N) and u of shape (m, N)."""
        return self._margin(x, u)[0].reshape(-1)

    def energy_gain(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return ∫yᵀu dt − ΔV, J, shape (N,), over ``duration_s`` after x (n, N) with u (m, N) held."""
        return self._energy_gain(duration_s)(x, u)[0].reshape(-1)

    def output(self, x: FloatArray) -> FloatArray:
        """Return outputs y, shape (m, N), for x of shape (n, N)."""
        return self._output()(x)[0]

    def stored(self, x: FloatArray) -> FloatArray:
        """Return the stored energy V(x), J, shape (N,), for x of shape (n, N)."""
        return self._stored()(x)[0].reshape(-1)

    def supplied(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return ∫yᵀu dt, J, shape (N,), over ``duration_s`` after x (n, N) with u (m, N) held."""
        return self._supplied(duration_s)(x, u)[0].reshape(-1)

    def flow(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return the state ``duration_s`` after x with u held, shape (n, N), for x (n, N) and u (m, N)."""
        return self._flow(duration_s)(x, u)[0]

    def flow_error(self, x: FloatArray, u: FloatArray, duration_s: float) -> FloatArray:
        """Return the estimated error of ``flow``, shape (N,), at most what the plant tolerates of its own."""
        estimated = self._flow_error(duration_s)(x, u)[0].reshape(-1)
        return np.minimum(np.nan_to_num(estimated, nan=LOCAL_TOLERANCE), LOCAL_TOLERANCE)

    def _derive_energy_gain(self, duration_s: float) -> BatchFunction:
        x_next, energy, _ = held_flow(self._system, duration_s)
        gain = energy - (ca.substitute(self._V, self._system.x, x_next) - self._V)
        return _evaluator("energy_gain", [self._system.x, self._system.u], gain)

    def _derive_supplied(self, duration_s: float) -> BatchFunction:
        _, energy, _ = held_flow(self._system, duration_s)
        return _evaluator("supplied", [self._system.x, self._system.u], energy)

    def _derive_flow_error(self, duration_s: float) -> BatchFunction:
        _, _, error = held_flow(self._system, duration_s)
        return _evaluator("flow_error", [self._system.x, self._system.u], error)

    def _derive_flow(self, duration_s: float) -> BatchFunction:
        x_next, _, _ = held_flow(self._system, duration_s)
        return _evaluator("flow", [self._system.x, self._system.u], x_next)


def _h_error(system: System, h: ca.SX) -> BatchFunction:
    x_error = ca.SX.sym("x_error", system.n)
    symbols, errors = ca.vertcat(system.x, system.t), ca.vertcat(x_error, 0)
    return _evaluator("h_error", [system.x, system.t, x_error], rounding_error(h, symbols, errors))


def _protected_levels(system: System, barriers: Sequence[Barrier]) -> dict[str, ca.SX]:
    """Return ψ₀ … ψ_{r−1} of every barrier by name."""
    chains = {chain.barrier.name: chain for barrier in barriers for chain in derive_chains(system, barrier)}
    return {f"ψ{level} of {name}": psi for name, chain in chains.items() for level, psi in enumerate(chain.psi[:-1])}


def _evaluator(name: str, arguments: Sequence[ca.SX], result: ca.SX) -> BatchFunction:
    return BatchFunction(dense_function(name, arguments, [result]), by_casadi=True)
