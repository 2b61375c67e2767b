"""Scenario of an operator that joins a running system: the system's own."""

import sys

from passafe_services.cli.errors import OptionError
from passafe_services.loop.bus import open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.running_scenario import running_scenario
from passafe_services.loop.shared_scenario import digest
from passafe_services.scenarios.schema import Scenario


def joined_scenario(own: Scenario, endpoint: RouterEndpoint, robot: str, *, is_given: bool) -> Scenario:
    """Return the scenario with which to join: the running filter's, or the own one while no filter says which.

    Args:
        own: Scenario of the command line.
        endpoint: Where the router listens.
        robot: The robot.
        is_given: Whether the user named the own one.

    Raises:
        OptionError: The user named another scenario than that of the running filter.
        ScenarioError: The filter's scenario cannot be used by this version.
        BusError: There is no router.
    """
    with open_bus(endpoint, robot=robot) as bus:
        running = running_scenario(bus)
    if running is None:
        sys.stderr.write(f"no filter has named its scenario: taking {own.name}\n")
        return own
    if is_given and running != own:
        got, allowed = (
            f"{each.name} ({each.rate_hz:g} Hz, digest {digest(each.model_dump_json())})" for each in (own, running)
        )
        raise OptionError("--scenario", got, f"the running system's, {allowed}: leave the option out to take that")
    return running
