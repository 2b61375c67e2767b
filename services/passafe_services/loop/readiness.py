"""How a process tells its supervisor that it is ready: one line on standard output."""

import sys
from typing import Final

_PREFIX: Final = "passafe-ready"


def ready_line(name: str) -> str:
    """The line that says that the process ``name`` has set itself up and does its work now."""
    return f"{_PREFIX} {name}"


def announce_ready(name: str) -> None:
    """Print the line."""
    sys.stdout.write(f"{ready_line(name)}\n")
    sys.stdout.flush()
