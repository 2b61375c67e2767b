"""The router: the process that every message passes through. Zenoh's own, no other program."""

from typing import Final

from services.router.port import is_taken
from services.runtime.bus import listening_router
from services.runtime.endpoint import LOOPBACK, Endpoint
from services.runtime.errors import BusError, PortInUseError
from services.runtime.readiness import announce_ready
from services.runtime.realtime import request_realtime
from services.runtime.stop import StopReason, stop_requests

NAME: Final = "router"


def run_router(port: int, *, host: str = LOOPBACK, lifeline: bool = False) -> StopReason | None:
    """Route until somebody ends it; main thread only.

    Args:
        port: TCP port to listen on.
        host: Address to listen on: loopback, unless other hosts are to take part.
        lifeline: Whether standard input is a lifeline (see ``services.runtime.stop``).

    Returns:
        Why it ended.

    Raises:
        EndpointError: If host or port can be no endpoint.
        PortInUseError: If the port is taken.
        BusError: If it cannot listen for another reason.
    """
    endpoint = Endpoint(host=host, port=port)
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
