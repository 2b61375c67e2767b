"""The home folder in an option: shells replace a ``~`` at the beginning of a word alone."""

import os


def with_home(argument: str) -> str:
    """Return ``--option=~/file`` with the home folder in it, and any other argument as it is.

    Otherwise ``--out=~/runs`` would make a folder that is called ``~``.
    """
    option, equals, value = argument.partition("=")
    if not option.startswith("--") or not value.startswith("~"):
        return argument
    return f"{option}{equals}{os.path.expanduser(value)}"  # noqa: PTH111 - raises nothing where there is no home
