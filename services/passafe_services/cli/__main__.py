"""Starts the command line: the console script ``passafe``, and ``python -m passafe_services.cli``."""

import os
import signal
import sys

from passafe_services.cli.failure import INTERRUPTED, refuse, refuse_missing_module
from passafe_services.cli.home_folder import with_home
from passafe_services.cli.version import version_text


def main() -> None:
    """Run the command line and exit with its code; without the packages of ``passafe[service]``, print what to install.

    Child processes inherit PYTHONSAFEPATH: no folder or module of the working directory can shadow what they import,
    also in those that ``multiprocessing`` starts without ``-P``.
    """
    if sys.argv[1:] == ["--version"]:  # needs no package beyond the base install
        sys.stdout.write(f"{version_text()}\n")
        return
    sys.argv[1:] = map(with_home, sys.argv[1:])
    os.environ["PYTHONSAFEPATH"] = "1"
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not ignored, as it is in the background
        signal.signal(signal.SIGINT, _end_while_loading)
    _run_commands()


def _end_while_loading(_signum: int, _frame: object) -> None:
    """End at once: a KeyboardInterrupt in one of the import system's callbacks would be lost."""
    os.write(sys.stderr.fileno(), b"interrupted\n")
    os._exit(INTERRUPTED)


def _run_commands() -> None:
    try:
        if sys.argv[1:2] in (["stop"], ["clear"]):
            from passafe_services.cli.stop import main as run_commands  # noqa: PLC0415 - loads a third of the others
        else:
            from passafe_services.cli.app import main as run_commands  # noqa: PLC0415 - a base install lacks these
    except ModuleNotFoundError as error:
        refuse_missing_module(error)
    except ImportError as error:  # a library that cannot be mapped into the address space
        refuse(f"cannot load a library: {error}: is memory limited (ulimit -v, a container's)?")
    except MemoryError:
        refuse("out of memory while loading: is there a limit (ulimit -v, a container's)?")
    if signal.getsignal(signal.SIGINT) is _end_while_loading:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run_commands()


if __name__ == "__main__":
    main()
