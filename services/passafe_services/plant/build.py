"""Builds the plant node of a scenario."""

from passafe_services.drivers.build import driver_of
from passafe_services.drivers.plant_driver import PlantDriver
from passafe_services.plant.driven_robot import DrivenRobot
from passafe_services.plant.guard import Guard
from passafe_services.plant.node import PlantNode
from passafe_services.plant.stop_latch import NO_STOP, StopLatch
from passafe_services.plant.unpredicted_node import UnpredictedPlantNode
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.schema import Scenario


def plant_node(
    scenario: Scenario,
    model: PlantModel | None = None,
    *,
    started_with: int = NO_STOP,
    driver: PlantDriver | None = None,
) -> PlantNode | UnpredictedPlantNode:
    """Return the plant of a scenario, for a filter with or without prediction.

    Args:
        scenario: The scenario.
        model: Its compiled model, if there is one already.
        started_with: Id of the emergency stop that is latched from the start; 0: none.
        driver: Reads and moves the robot, open; the scenario's if not given.

    Raises:
        ScenarioError: The scenario's driver has a clock of its own, and is not given: nobody opened it.
    """
    model = PlantModel.of(scenario) if model is None else model
    if driver is None:
        driver = driver_of(scenario, model)
        if driver.has_own_clock:
            allowed = "a simulation: a run in virtual time has no hardware"
            raise ScenarioError(scenario.name, "plant.driver.kind", scenario.plant.driver.kind, allowed)
    robot = DrivenRobot(
        driver,
        model.dynamics,
        model.fail_safe,
        x0=scenario.plant.x0,
        period_ns=model.period_ns,
        playout_ns=model.playout_ns,
        latch=StopLatch(started_with),
        guard=Guard(model.guard_core, model.guard_growth, period_ns=model.period_ns) if scenario.has_guard else None,
    )
    return (PlantNode if scenario.filter.prediction else UnpredictedPlantNode)(robot, model.limits)
