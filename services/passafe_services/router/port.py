"""Check of the router's port."""

import errno
import socket

from passafe_services.loop.errors import PortInUseError
from passafe_services.loop.router_endpoint import RouterEndpoint


def require_free_router_port(endpoint: RouterEndpoint) -> None:
    """Check that a router can listen at an endpoint, before anything else is started.

    Raises:
        PortInUseError: The port is in use, most likely by the router of another running system.
    """
    if is_taken(endpoint):
        raise PortInUseError(endpoint.host, endpoint.port)


def is_taken(endpoint: RouterEndpoint) -> bool:
    """Check whether an endpoint is in use."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(endpoint.host, endpoint.port, type=socket.SOCK_STREAM)[
            0
        ]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        return error.errno == errno.EADDRINUSE
    return False
