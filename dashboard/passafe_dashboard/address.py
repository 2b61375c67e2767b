"""Listen on the page's address, check beforehand that it is free, and tell whether others reach it."""

import errno
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from ipaddress import ip_address
from typing import Final

from passafe_dashboard.errors import PageAddressError, PagePortInUseError

LARGEST_PORT: Final = 65_535


def require_free_page_port(host: str, port: int) -> None:
    """Check that the page can be served, before anything else is started.

    Raises:
        PagePortInUseError: Another program listens on the port.
        PageAddressError: The address cannot be listened on for another reason.
    """
    with listening_socket(host, port):
        pass


@contextmanager
def listening_socket(host: str, port: int) -> Iterator[socket.socket]:
    """Listen at an address until the end of the block.

    Raises:
        PagePortInUseError: Another program listens on the port.
        PageAddressError: The address cannot be listened on for another reason.
    """
    if not 0 <= port <= LARGEST_PORT:
        raise PageAddressError(host, port, "no port number")
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((host, port), family=family, backlog=64)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise PagePortInUseError(host, port) from error
        raise PageAddressError(host, port, error.strerror or str(error)) from error
    with listener:
        yield listener


def is_address(host: str) -> bool:
    """Return whether a host is a numeric address."""
    try:
        ip_address(host)
    except ValueError:
        return False
    return True


def is_loopback(host: str) -> bool:
    """Return whether a host is a numeric address of loopback."""
    return is_address(host) and ip_address(host).is_loopback
