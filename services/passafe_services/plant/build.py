"""Builds the plant node of a scenario."""

from passafe_services.drivers.plant_driver import PlantDriver
from passafe_services.plant.node import PlantNode
from passafe_services.plant.stop_latch import NO_STOP, StopLatch
from passafe_services.plant.unpredicted_node import UnpredictedPlantNode
from passafe_services.plant_contract.plant_model import PlantModel
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
        driver: Reads and moves the robot, open; the exact model if not given.
    """
    model = PlantModel.of(scenario) if model is None else model
    node = PlantNode if scenario.filter.prediction else UnpredictedPlantNode
    return node(
        model.dynamics,
        model.fail_safe,
        x0=scenario.plant.x0,
        period_ns=model.period_ns,
        playout_ns=model.playout_ns,
        limits=model.limits,
        latch=StopLatch(started_with),
        driver=driver,
    )
