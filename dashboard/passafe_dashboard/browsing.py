"""Serve the pages of logs and experiments alone, without a robot beside them."""

import asyncio
import socket
from collections.abc import Callable
from pathlib import Path

from passafe_services.loop.router_endpoint import LOOPBACK
from passafe_services.loop.stop import Stop, stop_requests

from passafe_dashboard.address import listening_socket
from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.routes.application import create_browsing_app
from passafe_dashboard.routes.own_hosts import OwnHosts
from passafe_dashboard.server import page_server

CHECK_PERIOD_S = 0.05


def browse(root: Path, port: int, *, on_ready: Callable[[str], object]) -> None:
    """Serve the logs in a folder on loopback until asked to stop; main thread only.

    Args:
        root: The runs folder.
        port: TCP port of the page; 0 takes a free one.
        on_ready: Called with the page's address.

    Raises:
        PagePortInUseError: Another program listens on the port.
        PageAddressError: The address cannot be listened on for another reason.
    """
    with stop_requests(lifeline=False) as stop, listening_socket(LOOPBACK, port) as listener:
        asyncio.run(serve_archive(root, listener, stop, on_ready))


async def serve_archive(root: Path, listener: socket.socket, stop: Stop, on_ready: Callable[[str], object]) -> None:
    """Serve the logs in a folder until asked to stop.

    Args:
        root: The runs folder.
        listener: Socket that listens on loopback.
        stop: The request to stop.
        on_ready: Called with the page's address.
    """
    archive = Archive(root, beside_robot=False)
    server = page_server(create_browsing_app(archive, hosts=OwnHosts.of(LOOPBACK)))
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    ready = False
    while stop.reason is None and not serving.done():  # nothing sets an event: the request comes from a signal handler
        if server.started and not ready:
            ready = True
            on_ready(f"http://{LOOPBACK}:{listener.getsockname()[1]}/logs")
        await asyncio.sleep(CHECK_PERIOD_S)
    await archive.close()  # answers requests that wait for a job
    server.should_exit = True
    await serving
