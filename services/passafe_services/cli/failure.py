"""Reports to the user what goes wrong and is no defect of passafe."""

import errno
import sys
from collections.abc import Callable
from typing import Final, NoReturn

from passafe.errors import PassafeError

REFUSED: Final = 2
"""Exit code for input that cannot be used, and for whatever keeps a command from its work."""

UNWRITTEN: Final = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG, errno.EBADF})
"""Errors of a place that takes no more: a full disk behind a redirected output, say."""

LONGEST_NAME: Final = 100
"""Characters of a path that are shown where the path may be what is wrong."""

INTERRUPTED: Final = 130
"""Exit code after Ctrl-C, as shells have it."""


def run_reporting_errors(command: Callable[[], object]) -> None:
    """Run a command; print an error of passafe on standard error and exit, let any other end in its traceback.

    An error of the operating system about a file, or a full disk, is no defect of passafe, wherever it comes from.
    """
    try:
        command()
    except PassafeError as error:
        refuse(str(error))
    except OSError as error:
        refuse(_of_system(error))
    except ModuleNotFoundError as error:  # of a command that needs more than passafe[run]
        refuse_missing_module(error)
    except MemoryError:
        refuse("out of memory: is there a limit (ulimit -v, a container's)?")


def _of_system(error: OSError) -> str:
    """Return an error of the operating system in words; raise one that says of no file or device what is wrong."""
    if error.strerror and error.filename is not None:
        name = str(error.filename)
        shown = name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}… ({len(name)} characters)"
        return f"{shown}: {error.strerror}"
    if error.errno in UNWRITTEN:
        return f"cannot write what it prints, or a file: {error.strerror}"
    raise error


def refuse_missing_module(error: ModuleNotFoundError) -> NoReturn:
    """Print what to install and exit with ``REFUSED``; raise the error if the module is one of ours."""
    if error.name is None or error.name.startswith("passafe"):
        raise error
    refuse(f"no module {error.name!r}: install the commands: pip install 'passafe[service]'")


def refuse(text: str) -> NoReturn:
    """Print a line on standard error and exit with ``REFUSED``."""
    sys.stderr.write(f"passafe: {text}\n")
    sys.exit(REFUSED)
