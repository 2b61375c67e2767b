"""Builds the core's sets of a scenario, and the robot as it really is."""

from collections.abc import Mapping
from dataclasses import replace

from passafe.errors import DesignError
from passafe.models.robot import Robot
from passafe.system import System
from passafe.uncertainty import Uncertainty
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.state_numbers import state_numbers
from passafe_services.suggestion import suggestion


def uncertainty_of(scenario: Scenario, robot: Robot) -> Uncertainty | None:
    """Return the scenario's sets; ``None`` if it has none.

    Raises:
        ScenarioError: Parameters that the robot does not have, intervals without the model's value, or lists of another
            length than it has states.
    """
    config = scenario.uncertainty
    if config is None:
        return None
    _require_known(scenario, "uncertainty.parameters", config.parameters, robot.system)
    sets = Uncertainty(
        parameters={name: (low, high) for name, (low, high) in config.parameters.items()},
        disturbance=state_numbers(scenario.name, "uncertainty.disturbance", config.disturbance, robot),
        state_error=state_numbers(scenario.name, "uncertainty.state_error", config.state_error, robot),
        actuator_lag_s=config.actuator_lag_s,
    )
    try:
        sets.require_fits(robot.system)
    except DesignError as error:
        field = error.field.replace("'", "").replace(" ", ".")
        raise ScenarioError(scenario.name, field, str(error.got), error.allowed) from error
    return sets


def guard_uncertainty_of(scenario: Scenario, robot: Robot) -> Uncertainty | None:
    """Return the sets of the guard at the plant, which reads the state itself; ``None`` if it has none.

    Raises:
        ScenarioError: As for ``uncertainty_of``.
    """
    sets, guard = uncertainty_of(scenario, robot), scenario.plant.guard
    if guard is None or guard.state_error is None:
        return sets
    own = state_numbers(scenario.name, "plant.guard.state_error", guard.state_error, robot)
    return replace(Uncertainty() if sets is None else sets, state_error=own)


def reading_error_of(scenario: Scenario, robot: Robot) -> tuple[float, ...]:
    """Return the largest error of each state as the plant reads it, n numbers; 0 where the model is the robot.

    Raises:
        ScenarioError: As for ``uncertainty_of``.
    """
    sets = None if scenario.plant.driver.kind == "model" else guard_uncertainty_of(scenario, robot)
    return (0.0,) * robot.system.n if sets is None or not sets.state_error else tuple(sets.state_error)


def true_system_of(scenario: Scenario, robot: Robot) -> System:
    """Return the dynamics of the simulated robot with the parameters that it really has.

    Raises:
        ScenarioError: Parameters that the robot does not have.
    """
    truth = scenario.plant.truth
    if truth is None or not truth.parameters:
        return robot.system
    _require_known(scenario, "plant.truth.parameters", truth.parameters, robot.system)
    return robot.system.with_parameters(truth.parameters)


def _require_known(scenario: Scenario, field: str, given: Mapping[str, object], system: System) -> None:
    known = [parameter.name for parameter in system.parameters]
    unknown = sorted(set(given) - set(known))
    if unknown:
        allowed = (", ".join(known) or "none: the robot states no parameters") + suggestion(unknown[0], known)
        raise ScenarioError(scenario.name, field, ", ".join(unknown), allowed)
