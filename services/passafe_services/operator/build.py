"""Builds the operator node of a scenario."""

from passafe_services.operator.node import OperatorNode
from passafe_services.operator.sources.scenario_source import source_of
from passafe_services.scenarios.schema import Scenario


def operator_node(scenario: Scenario, epoch: int) -> OperatorNode:
    """Return the operator of a scenario, script or simulated person, with session ``epoch``."""
    return OperatorNode(source_of(scenario), epoch=epoch)
