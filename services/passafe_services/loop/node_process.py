"""A node as a process at the scenario's rate."""

from collections.abc import Callable

from passafe_services.loop.live import run_live
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.node import Node
from passafe_services.scenarios.links import link_changes, link_settings


def run_node(
    node: Node,
    options: ProcessOptions,
    *,
    epoch: int | None = None,
    finished: Callable[[], bool] | None = None,
) -> None:
    """Step a node against the clock until told to stop.

    Args:
        node: The node.
        options: Scenario, endpoint and lifeline.
        epoch: Session number, if the node must know it.
        finished: Asked before each step whether the node wants no more.
    """
    run_live(
        node,
        rate_hz=options.scenario.rate_hz,
        endpoint=options.endpoint,
        links=link_settings(options.scenario),
        link_changes=link_changes(options.scenario),
        epoch=epoch,
        lifeline=options.lifeline,
        finished=finished,
    )
