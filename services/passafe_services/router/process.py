"""The router: the process that every message passes through. Zenoh's own, no other program."""

from typing import Final

from passafe_services.loop.bus import listening_router
from passafe_services.loop.errors import BusError, PortInUseError
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.loop.readiness import announce_ready
from passafe_services.loop.realtime import request_realtime
from passafe_services.loop.router_endpoint import LOOPBACK, RouterEndpoint
from passafe_services.loop.stop import StopReason, stop_requests
from passafe_services.router.port import is_taken

NAME: Final = "router"


def run_router(port: int, *, host: str = LOOPBACK, lifeline: bool = False) -> StopReason | None:
    """Route until somebody ends it; main thread only.

    Args:
        port: TCP port to listen on.
        host: Address to listen on: loopback, unless other hosts are to take part.
        lifeline: Whether standard input is a lifeline (see ``passafe_services.loop.stop``).

    Returns:
        Why it ended.

    Raises:
        EndpointError: If host or port can be no endpoint.
        PortInUseError: If the port is taken.
        BusError: If it cannot listen for another reason.
    """
    endpoint = RouterEndpoint(host=host, port=port)
    request_realtime()  # the processes that keep a rate say so if it is refused
    with stop_requests(lifeline=lifeline) as stop:
        try:
            with listening_router(endpoint):
                announce_ready(NAME)
                stop.wait()
        except BusError as error:
            if is_taken(endpoint):
                raise PortInUseError(host, port) from error
            raise
    return stop.reason


def start(options: ProcessOptions) -> None:
    """Route until told to stop."""
    run_router(options.endpoint.port, host=options.endpoint.host, lifeline=options.lifeline)
