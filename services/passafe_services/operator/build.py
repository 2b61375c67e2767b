"""Builds the operator node of a scenario."""

from passafe_services.operator.node import OperatorNode
from passafe_services.operator.page.page_driver import PageDriver
from passafe_services.operator.sources.scenario_source import source_of
from passafe_services.scenarios.driving_axes import DrivingAxes
from passafe_services.scenarios.schema import Scenario


def operator_node(
    scenario: Scenario, epoch: int, *, takes_over: bool = False, follows_page: bool = False
) -> OperatorNode:
    """Return the operator of a scenario, script or simulated person.

    Args:
        scenario: The scenario.
        epoch: Its session.
        takes_over: Whether it takes the lease over from the operator that holds it.
        follows_page: Whether a page may take its place.
    """
    page = PageDriver(DrivingAxes.of(scenario).full, epoch=epoch) if follows_page else None
    return OperatorNode(source_of(scenario), epoch=epoch, takes_over=takes_over, page=page)
