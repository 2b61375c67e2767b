"""Options for a robot of the user's own, and of commands that name a robot on the bus as well."""

from collections.abc import Sequence
from typing import Annotated

import typer
from passafe_protocol.keys import DEFAULT_ROBOT, require_robot_name

from passafe_services.cli.errors import OptionError
from passafe_services.scenarios.robots.robot_source import is_robot_file

OwnRobotOption = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="FILE.py:FUNCTION",
        help="Robot of your own instead of the scenario's model: runs that file; the log then carries the robot.",
    ),
]
LiveRobotOption = Annotated[
    list[str] | None,
    typer.Option(
        "--robot",
        metavar="NAME|FILE.py:FUNCTION",
        envvar="PASSAFE_ROBOT",
        help="Name of the robot, part of every key on the bus; or a robot of your own, as a function of a file that "
        "is run. Repeat for both.",
    ),
]


def name_and_file(given: Sequence[str] | None) -> tuple[str, str | None]:
    """Return the name of the robot on the bus, and the function of a robot of the user's own if there is one.

    Raises:
        OptionError: More than one of either.
        InvalidRobotNameError: A name that no key may hold.
    """
    files = [text for text in given or () if is_robot_file(text)]
    names = [text for text in given or () if not is_robot_file(text)]
    if len(files) > 1 or len(names) > 1:
        raise OptionError("--robot", ", ".join(given or ()), "one NAME, one FILE.py:FUNCTION, or both")
    return require_robot_name(names[0] if names else DEFAULT_ROBOT), files[0] if files else None
