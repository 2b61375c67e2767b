"""Readiness protocol between a process and its supervisor: one line on standard output."""

import sys
from typing import Final

_PREFIX: Final = "passafe-ready"


def ready_line(name: str) -> str:
    """Return the line with which the process ``name`` reports that it is ready."""
    return f"{_PREFIX} {name}"


def announce_ready(name: str) -> None:
    """Print the ready line of the process ``name``."""
    sys.stdout.write(f"{ready_line(name)}\n")
    sys.stdout.flush()
