"""Reports to the user what goes wrong and is no defect of passafe."""

import sys
from collections.abc import Callable
from typing import Final

REFUSED: Final = 2
"""Exit code for input that cannot be used, and for whatever keeps a command from its work."""

_OURS: Final = frozenset({"passafe", "passafe_protocol", "passafe_services", "passafe_dashboard"})


def run_reporting_errors(command: Callable[[], object]) -> None:
    """Run a command; print an error of ours on standard error and exit, let any other end in its traceback.

    Every exception class that passafe defines is a message to the user: what, got, allowed. They are recognised by
    the module that defines them, so that a small process need not import the packages of all the others.
    """
    try:
        command()
    except Exception as error:
        if type(error).__module__.partition(".")[0] not in _OURS:
            raise
        sys.stderr.write(f"passafe: {error}\n")
        sys.exit(REFUSED)
