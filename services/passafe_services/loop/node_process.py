"""Runs a node as a process at the scenario's rate."""

from collections.abc import Callable

from passafe_services.loop.hang_watch import Call
from passafe_services.loop.live import run_live
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.node import Node
from passafe_services.scenarios.links import link_changes, link_settings


def run_node(
    node: Node,
    options: ProcessOptions,
    *,
    finished: Callable[[], bool] | None = None,
    begun: Callable[[], object] = lambda: None,
    ended: Callable[[], object] = lambda: None,
    waits_in: Callable[[], Call | None] | None = None,
) -> None:
    """Step a node in real time until it is stopped.

    Args:
        node: The node.
        options: Scenario, endpoint, robot, epoch, lifeline and health.
        finished: Called before each step; true ends the run.
        begun: Called on the bus, before the first step.
        ended: Called after the last step, also after an error.
        waits_in: Returns the call of somebody's code that the node waits for, if any (``run_live``).
    """
    run_live(
        node,
        rate_hz=options.scenario.rate_hz,
        endpoint=options.endpoint,
        robot=options.robot,
        links=link_settings(options.scenario),
        link_changes=link_changes(options.scenario),
        epoch=options.epoch,
        lifeline=options.lifeline,
        finished=finished,
        begun=begun,
        ended=ended,
        waits_in=waits_in,
        health=options.health,
        scenario_json=options.scenario.model_dump_json(),
    )
