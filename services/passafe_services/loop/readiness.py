"""Readiness protocol between a process and its supervisor: one line on standard output, or systemd's notification."""

import sys
from typing import Final

from passafe_services.loop.service_manager import READY, notify_service_manager

_PREFIX: Final = "passafe-ready"


def ready_line(name: str) -> str:
    """Return the line with which the process ``name`` reports that it is ready."""
    return f"{_PREFIX} {name}"


def announce_ready(name: str) -> None:
    """Print the ready line of the process ``name`` and notify a service manager."""
    sys.stdout.write(f"{ready_line(name)}\n")
    sys.stdout.flush()
    notify_service_manager(READY)
