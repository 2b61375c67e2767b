"""Notifications to a service manager, by the protocol of systemd: sd_notify(3)."""

import os
import socket
from contextlib import suppress
from typing import Final

SOCKET_VARIABLE: Final = "NOTIFY_SOCKET"
"""Environment variable by which a service manager names its socket; a first ``@`` stands for an abstract address."""

READY: Final = "READY=1"
ALIVE: Final = "WATCHDOG=1"


def service_manager_listens() -> bool:
    """Return whether a service manager has named its socket."""
    return SOCKET_VARIABLE in os.environ


def notify_service_manager(*assignments: str) -> None:
    """Send ``NAME=VALUE`` assignments to the service manager; nothing happens without one, or if it does not listen.

    The call never blocks, so a control loop may make it.
    """
    address = os.environ.get(SOCKET_VARIABLE, "")
    if not address:
        return
    if address.startswith("@"):
        address = f"\0{address[1:]}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender, suppress(OSError):
        sender.setblocking(False)
        sender.sendto("\n".join(assignments).encode(), address)
