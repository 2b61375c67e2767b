"""Whether the router's port can be had."""

import errno
import socket

from passafe_services.loop.errors import PortInUseError
from passafe_services.loop.router_endpoint import RouterEndpoint


def require_free_router_port(endpoint: RouterEndpoint) -> None:
    """Make sure that a router could listen at an endpoint, before anything else is started.

    Raises:
        PortInUseError: Somebody listens there already, most likely the router of another running system.
    """
    if is_taken(endpoint):
        raise PortInUseError(endpoint.host, endpoint.port)


def is_taken(endpoint: RouterEndpoint) -> bool:
    """Tell whether somebody else listens at an endpoint."""
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
