"""Builds the command source of a scenario, including those that depend on the robot."""

from pathlib import Path

from passafe_services.operator.errors import SourceConfigError
from passafe_services.operator.human.crossover import CrossoverLoop
from passafe_services.operator.human.human import SimulatedHuman
from passafe_services.operator.human.steered_robot import SteeredRobot
from passafe_services.operator.sources.adversary import adversary_of
from passafe_services.operator.sources.command_recording import LARGEST
from passafe_services.operator.sources.script_source import build_source
from passafe_services.operator.sources.source import CommandSource
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import AdversarySource, HumanSource


def source_of(scenario: Scenario, *, folder: Path | None = None) -> CommandSource:
    """Return the command source of a scenario, other than a keyboard.

    Args:
        scenario: The scenario.
        folder: Folder of the scenario file, as for ``build_source``.

    Raises:
        SourceConfigError: A setting does not fit the robot or is out of range.
        RecordingError: Recorded commands cannot be read.
    """
    config = scenario.operator.source
    if isinstance(config, HumanSource):
        return _human(config, scenario)
    if isinstance(config, AdversarySource):
        return adversary_of(config, scenario)
    return build_source(config, robot_of(scenario).commands, folder=folder)


def crossover_loop(config: HumanSource) -> CrossoverLoop:
    """Return the loop of a person and the steered robot, for its margins."""
    return CrossoverLoop(
        crossover_rad_per_s=config.crossover_rad_per_s,
        reaction_s=config.reaction_s,
        neuromuscular_s=config.neuromuscular_s,
        glance_s=config.glance_s,
    )


def _human(config: HumanSource, scenario: Scenario) -> SimulatedHuman:
    robot = SteeredRobot.of(scenario)
    for index, target in enumerate(config.targets):
        field = f"targets[{index}].position"
        if len(target.position) != robot.axes:
            raise SourceConfigError(field, target.position, f"{robot.axes} numbers, one for each coordinate")
        if any(abs(value) > LARGEST for value in target.position):
            raise SourceConfigError(field, target.position, f"numbers from {-LARGEST:g} to {LARGEST:g}")
    return SimulatedHuman(config, robot)
