"""A simulated robot that is not its model: other parameters, disturbances, noise and lag of its actuators."""

from collections.abc import Sequence
from math import exp

import casadi as ca
from passafe_protocol.messages import Vector

from passafe.sampled_plant import SampledPlant
from passafe.system import System
from passafe_services.drivers.disturbance import Disturbing, Greedy, sine, switching
from passafe_services.drivers.plant_driver import Reading
from passafe_services.drivers.state_measurement import StateMeasurement
from passafe_services.plant_contract.plant_model import PlantModel, period_ns
from passafe_services.scenarios.design import barriers_of, storage_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.state_numbers import state_numbers
from passafe_services.scenarios.truth_schema import (
    ConstantDisturbance,
    GreedyDisturbance,
    SineDisturbance,
    SwitchingDisturbance,
    TruthConfig,
)
from passafe_services.scenarios.uncertain_robot import true_system_of


class TrueModelDriver:
    """Integrates the robot as it really is, one period at a time, under the input applied last.

    All that is drawn depends on seeds and on the number of the period since the first input, so that live and lockstep
    runs meet the same robot, and a run can be repeated to the last bit.

    Attributes:
        has_own_clock: False: a simulation.
    """

    has_own_clock = False

    def __init__(
        self,
        plant: SampledPlant,
        measurement: StateMeasurement,
        disturbance: Disturbing | None,
        *,
        x0: Sequence[float],
        period_ns: int,
        actuator_lag_s: float = 0.0,
    ) -> None:
        """Put the robot at rest at x0.

        Args:
            plant: The robot, stepped with the period; its inputs are u, and after them disturbances of all n rates.
            measurement: Reads its state.
            disturbance: What disturbs it; ``None`` for nothing.
            x0: Initial state, n numbers.
            period_ns: Period of a step, ns.
            actuator_lag_s: First-order lag of the actuators, which hold their force over a period, s.
        """
        self._plant = plant
        self._x: Vector = tuple(x0)
        self._disturbance, self._measurement = disturbance, measurement
        self._calm: Vector = (0.0,) * plant.system.n
        self._period_ns = period_ns
        self._kept = exp(-period_ns * 1e-9 / actuator_lag_s) if actuator_lag_s else 0.0
        self._u: Vector = ()
        self._acting: Vector = (0.0,) * (plant.system.m - plant.system.n)
        self._at_ns = 0
        self._period = 0

    @classmethod
    def of(cls, scenario: Scenario, model: PlantModel, truth: TruthConfig) -> "TrueModelDriver":
        """Return the driver of a scenario's true robot.

        Args:
            scenario: The scenario.
            model: Its compiled model.
            truth: What the robot really is.

        Raises:
            ScenarioError: Parameters that the robot does not have, or lists of another length than it has states.
        """
        robot, n = model.robot, model.robot.system.n
        zeros = (0.0,) * n
        noise, steps = truth.noise, truth.quantisation
        return cls(
            SampledPlant(_disturbed(true_system_of(scenario, robot)), storage_of(scenario, robot), scenario.dt_s),
            StateMeasurement(
                bound=zeros
                if noise is None
                else state_numbers(scenario.name, "plant.truth.noise.bound", noise.bound, robot),
                seed=0 if noise is None else noise.seed,
                steps=zeros
                if steps is None
                else state_numbers(scenario.name, "plant.truth.quantisation", steps, robot),
            ),
            _disturbance_of(scenario, model, truth),
            x0=scenario.plant.x0,
            period_ns=period_ns(scenario),
            actuator_lag_s=truth.actuator_lag_s,
        )

    def open(self) -> None:
        """Do nothing: a model is always ready."""

    def read(self, at_ns: int) -> Reading:
        """Return the state at ``at_ns`` as it is measured; x0 before the first input."""
        if self._u:
            while self._at_ns + self._period_ns <= at_ns:
                self._advance()
                self._at_ns += self._period_ns
        return Reading(self._measurement.of(self._x, self._period), at_ns, true_x=self._x)

    def apply(self, u: Vector, at_ns: int) -> None:
        """Put an input in force."""
        self._u, self._at_ns = u, at_ns

    def close(self) -> None:
        """Do nothing: a model stops when it is asked no more."""

    def _advance(self) -> None:
        """Advance the robot by one period."""
        kept, acting = self._kept, self._u
        if kept:
            acting = tuple(now + kept * (was - now) for was, now in zip(self._acting, acting, strict=True))
        self._acting = acting
        t_s = self._period * self._plant.dt_s
        w = self._calm if self._disturbance is None else self._disturbance(t_s, self._x)
        self._x = self._plant.advance(self._x, (*acting, *w)).x
        self._period += 1


def _disturbed(system: System) -> System:
    """Return a system with a disturbance of every rate as further inputs; none of them crosses the port."""
    w = ca.SX.sym("w", system.n)
    return System(
        x=system.x,
        u=ca.vertcat(system.u, w),
        f=system.f + w,
        y=system.y,
        t=system.t,
        port_y=system.port_y,
        port_u=system.port_u,
    )


def _disturbance_of(scenario: Scenario, model: PlantModel, truth: TruthConfig) -> Disturbing | None:
    config, robot = truth.disturbance, model.robot
    if config is None:
        return None
    if isinstance(config, ConstantDisturbance):
        rate = state_numbers(scenario.name, "plant.truth.disturbance.rate", config.rate, robot)
        return lambda _t_s, _x: rate
    bound = state_numbers(scenario.name, "plant.truth.disturbance.bound", config.bound, robot)
    match config:
        case SwitchingDisturbance():
            return switching(bound, config.every_s, config.seed)
        case SineDisturbance():
            return sine(bound, config.period_s)
        case GreedyDisturbance():
            return Greedy(bound, robot.system, barriers_of(scenario, robot))
