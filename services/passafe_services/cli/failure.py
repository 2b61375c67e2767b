"""Reports to the user what goes wrong and is no defect of passafe."""

import sys
from collections.abc import Callable
from typing import Final

from passafe.errors import PassafeError

REFUSED: Final = 2
"""Exit code for input that cannot be used, and for whatever keeps a command from its work."""


def run_reporting_errors(command: Callable[[], object]) -> None:
    """Run a command; print an error of passafe on standard error and exit, let any other end in its traceback."""
    try:
        command()
    except PassafeError as error:
        sys.stderr.write(f"passafe: {error}\n")
        sys.exit(REFUSED)
