"""The page's address and its web server."""

import errno
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import uvicorn
from fastapi import FastAPI

from dashboard.errors import PageAddressError, PagePortInUseError

LARGEST_PORT: Final = 65_535


class PageServer(uvicorn.Server):
    """A web server that leaves the signals to whoever runs it."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Take no signal."""
        yield


def page_server(app: FastAPI) -> PageServer:
    """Server for the application, not started yet."""
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        ws="websockets-sansio",
        ws_per_message_deflate=False,  # loopback has the room; compression would cost what it saves
        ws_ping_interval=5.0,
        ws_ping_timeout=10.0,
        timeout_graceful_shutdown=1,
    )
    return PageServer(config)


def require_free_page_port(host: str, port: int) -> None:
    """Make sure that the page could be served, before anything else is started.

    Raises:
        PagePortInUseError: Another program listens on the port.
        PageAddressError: The address cannot be listened on for another reason.
    """
    with listening_socket(host, port):
        pass


@contextmanager
def listening_socket(host: str, port: int) -> Iterator[socket.socket]:
    """Socket that listens at an address, closed at the end of the block.

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
