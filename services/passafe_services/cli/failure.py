"""Reports to the user what goes wrong and is no defect of passafe."""

import sys
from collections.abc import Callable
from typing import Final, NoReturn

from passafe.errors import PassafeError

REFUSED: Final = 2
"""Exit code for input that cannot be used, and for whatever keeps a command from its work."""

INTERRUPTED: Final = 130
"""Exit code after Ctrl-C, as shells have it."""


def run_reporting_errors(command: Callable[[], object]) -> None:
    """Run a command; print an error of passafe on standard error and exit, let any other end in its traceback."""
    try:
        command()
    except PassafeError as error:
        refuse(str(error))
    except ModuleNotFoundError as error:  # of a command that needs more than passafe[run]
        refuse_missing_module(error)
    except MemoryError:
        refuse("out of memory: is there a limit (ulimit -v, a container's)?")


def refuse_missing_module(error: ModuleNotFoundError) -> NoReturn:
    """Print what to install and exit with ``REFUSED``; raise the error if the module is one of ours."""
    if error.name is None or error.name.startswith("passafe"):
        raise error
    refuse(f"no module {error.name!r}: install the commands: pip install 'passafe[service]'")


def refuse(text: str) -> NoReturn:
    """Print a line on standard error and exit with ``REFUSED``."""
    sys.stderr.write(f"passafe: {text}\n")
    sys.exit(REFUSED)
