"""Router process: runs Zenoh's router in this process, without another program."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from passafe_services.loop.bus import open_bus
from passafe_services.loop.errors import BusError, PortInUseError
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.realtime import request_realtime
from passafe_services.loop.router_endpoint import LOOPBACK, RouterEndpoint
from passafe_services.loop.routing import listening_router
from passafe_services.loop.stop import Stop, StopReason, stop_requests
from passafe_services.router.port import is_taken

NAME: Final = "router"
HEALTH_PERIOD_S: Final = 1.0
_EVERY_ADDRESS: Final = ("0.0.0.0", "::")  # noqa: S104 - what a router may listen on


def run_router(
    endpoint: RouterEndpoint,
    *,
    linked: Sequence[RouterEndpoint] = (),
    lifeline: bool = False,
    health: HealthReporter | None = None,
) -> StopReason | None:
    """Route messages until stopped; main thread only.

    Args:
        endpoint: Address to listen on: loopback, unless other hosts are to connect; with the router's keys.
        linked: Routers of other sites that it connects to.
        lifeline: Whether standard input is a lifeline (see ``passafe_services.loop.stop``).
        health: Reports whether it answers a client, to what supervises the process.

    Returns:
        Reason for the end.

    Raises:
        PortInUseError: The port is in use.
        BusError: It cannot listen for another reason.
    """
    request_realtime()  # a refusal is reported by the processes with a control loop
    with stop_requests(lifeline=lifeline) as stop:
        try:
            with listening_router(endpoint, linked):
                announce_ready(NAME)
                if health is not None and health.wanted:
                    _report_until_stopped(endpoint, stop, health)
                stop.wait()
        except BusError as error:
            if is_taken(endpoint):
                raise PortInUseError(endpoint.host, endpoint.port) from error
            raise
    return stop.reason


def _report_until_stopped(endpoint: RouterEndpoint, stop: Stop, health: HealthReporter) -> None:
    """Be a client of this router and report, once a second, whether it answers."""
    own = replace(endpoint, host=LOOPBACK) if endpoint.host in _EVERY_ADDRESS else endpoint
    with open_bus(own) as client:
        steps = 0
        while not stop.wait(HEALTH_PERIOD_S):
            steps += 1
            health.report(connected=client.connected, steps=steps, skipped=0)


def start(options: ProcessOptions) -> None:
    """Route messages until stopped."""
    run_router(
        options.endpoint,
        linked=options.linked_routers,
        lifeline=options.lifeline,
        health=options.health,
    )
