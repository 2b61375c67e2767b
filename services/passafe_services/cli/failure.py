"""One clear line for what goes wrong and is no defect of ours."""

import sys
from collections.abc import Callable
from typing import Final

REFUSED: Final = 2
"""Exit code for input that cannot be used, and for what keeps a command from doing its work."""

_OURS: Final = frozenset({"passafe", "passafe_protocol", "passafe_services", "passafe_dashboard"})


def with_one_line(command: Callable[[], object]) -> None:
    """Run a command; an error of ours ends it with one line on standard error, any other with its traceback.

    Every exception class that passafe defines is a message to the user: what, got, allowed. They are told by where
    they are defined, so that a small process need not import the packages of all the others.
    """
    try:
        command()
    except Exception as error:
        if type(error).__module__.partition(".")[0] not in _OURS:
            raise
        sys.stderr.write(f"passafe: {error}\n")
        sys.exit(REFUSED)
