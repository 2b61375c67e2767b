"""Functions that return robots: of a file that the command line names, or of an installed distribution."""

import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, Final
from zlib import crc32

from pydantic import ValidationError

from passafe.arguments.numbers import described
from passafe.errors import DesignError, NotAllowedError, PassafeError
from passafe.models.robot import Robot
from passafe_services.foreign_errors import is_ctrl_c, words_of
from passafe_services.scenarios.errors import RobotCodeError
from passafe_services.scenarios.field_problems import problems_of
from passafe_services.scenarios.robots.carried_robot import CarriedRobot
from passafe_services.scenarios.robots.shipped import SHIPPED
from passafe_services.suggestion import suggestion

ENTRY_POINTS: Final = "passafe.robots"
"""Group of entry points by which installed distributions add robots."""

FORM: Final = "FILE.py:FUNCTION"

RobotFunction = Callable[..., Any]


def installed_robots() -> Mapping[str, Sequence[EntryPoint]]:
    """Return the entry points of robots by name, several where distributions share one; none of them is loaded."""
    found: dict[str, list[EntryPoint]] = {}
    for entry in sorted(entry_points(group=ENTRY_POINTS), key=lambda entry: (entry.name, entry.value)):
        found.setdefault(entry.name, []).append(entry)
    return found


def is_installed(name: str) -> bool:
    """Return whether passafe ships a robot of that name, or an entry point has it."""
    return name in SHIPPED or name in installed_robots()


def installed_robot(name: str, parameters: Mapping[str, float]) -> CarriedRobot | None:
    """Return a robot that passafe ships, or that of an entry point; ``None`` if there is none of that name.

    Raises:
        RobotCodeError: Its function cannot be loaded, raises, or returns no robot; or several distributions have that
            name.
    """
    if name in SHIPPED:
        return carried(SHIPPED[name], f"{SHIPPED[name].__module__}:{name}", parameters)
    entries = installed_robots().get(name, ())
    if not entries:
        return None
    source = f"entry point {name}"
    if len({entry.value for entry in entries}) > 1:
        found = " and ".join(_origin(entry) for entry in entries)
        raise RobotCodeError(source, found, "one of them: uninstall the other, or name its file with --robot")
    return carried(_loaded(entries[0].load, source), source, parameters)


def _origin(entry: EntryPoint) -> str:
    """Return which function an entry point names, and of which distribution it is where that is known."""
    return entry.value if entry.dist is None else f"{entry.value} of {entry.dist.name}"


def is_robot_file(text: str) -> bool:
    """Return whether a text is meant as ``FILE.py:FUNCTION``: no name of a robot has a colon, a slash or ``.py``."""
    return ":" in text or "/" in text or text.endswith(".py")


def robot_of_file(text: str, parameters: Mapping[str, float]) -> CarriedRobot:
    """Return the robot that a function of a file returns: runs the file, once in each process.

    Args:
        text: ``FILE.py:FUNCTION``; a ``~`` in front is the home folder, also where no shell replaced it.
        parameters: Keyword arguments of the function.

    Raises:
        RobotCodeError: No such file or function, or one that raises or returns no robot.
    """
    path, separator, name = text.rpartition(":")
    if not separator or not path.endswith(".py") or not name.isidentifier():
        raise RobotCodeError(text, repr(text), FORM)
    file = Path(os.path.expanduser(path))  # noqa: PTH111 - Path.expanduser raises where a user has no home
    if not file.is_file():
        raise RobotCodeError(text, f"no file {file}", f"{FORM} of a file that exists")
    file = file.resolve()
    functions = _functions(file)
    function = functions.get(name)
    if not callable(function):
        known = [each for each, value in functions.items() if callable(value) and not each.startswith("_")]
        raise RobotCodeError(text, f"no function {name!r}", "one of the file" + suggestion(name, known))
    with _importing_beside(file):
        return carried(function, text, parameters)


def carried(function: RobotFunction, source: str, parameters: Mapping[str, float]) -> CarriedRobot:
    """Return what a function returns, as data.

    Raises:
        RobotCodeError: It raises, or returns no robot.
    """
    robot = _loaded(lambda: function(**parameters), source)
    if not isinstance(robot, Robot):
        raise RobotCodeError(source, f"the return value {described(robot)}", "a passafe.Robot")
    try:
        return CarriedRobot.of(robot, made_by=Path(source).name, built_with=parameters)
    except DesignError as error:
        raise RobotCodeError(source, str(error.got), error.allowed, error.field) from error
    except ValidationError as error:
        first = problems_of(error, CarriedRobot)[0]
        raise RobotCodeError(source, f"{first.field} {first.got}", first.allowed) from error


@cache
def _functions(path: Path) -> Mapping[str, Any]:
    """Return the names that a file defines; the files beside it can be imported while it runs."""
    name = f"passafe_robot_{crc32(bytes(path)):08x}_{path.stem}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise RobotCodeError(str(path), "a file that is no Python", FORM)
    module, loader = module_from_spec(spec), spec.loader
    sys.modules[name] = module  # dataclasses and pickle look a class's module up there
    try:
        with _importing_beside(path):
            _loaded(lambda: loader.exec_module(module), str(path))
    except RobotCodeError:
        del sys.modules[name]
        raise
    return vars(module)


@contextmanager
def _importing_beside(path: Path) -> Iterator[None]:
    """Let the code of a file import the files beside it: when it is run, and when its function is called."""
    folder = str(path.parent)
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        if folder in sys.path:  # that code may have changed the list, too
            sys.path.remove(folder)


def _loaded(run: Callable[[], Any], source: str) -> Any:  # noqa: ANN401 - a stranger's function may return anything
    """Return what a stranger's code returns; whatever it raises becomes one line that names it."""
    try:
        with redirect_stdout(sys.stderr):  # what a command prints for programs is not mixed with what that code prints
            return run()
    except NotAllowedError as error:
        raise RobotCodeError(source, str(error.got), error.allowed, error.field) from error
    except PassafeError as error:
        raise RobotCodeError(source, str(error), "a function that returns a passafe.Robot") from error
    except BaseException as error:
        if is_ctrl_c(error):
            raise
        got = words_of(error, _line_of(error, source))
        raise RobotCodeError(source, got, "a function that returns a passafe.Robot") from error


def _line_of(error: BaseException, source: str) -> str:
    """Return the last line of the stranger's own file that led to an error, in words."""
    file, trace, line = source.rpartition(":")[0] or source, error.__traceback__, 0
    while trace is not None:
        if Path(trace.tb_frame.f_code.co_filename).name == Path(file).name:
            line = trace.tb_lineno
        trace = trace.tb_next
    return f" in line {line}" if line else ""
