"""Errors of scenario files; the tree of all errors is in ``passafe.errors``."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from passafe.errors import NotAllowedError
from passafe_services.scenarios.field_problems import FieldProblem, problems_text
from passafe_services.suggestion import suggestion


class ConfigurationError(NotAllowedError):
    """A file of configuration with fields that hold what they may not.

    Attributes:
        noun: What the file holds.
        name: Its name, or that of the file.
        field: Dotted name of the first of the fields; ``got`` and ``allowed`` are of it, too.
    """

    noun: ClassVar[str]

    def __init__(self, name: str, field: str, got: object, allowed: str, *more: FieldProblem) -> None:
        self.name = name
        super().__init__(field, got, allowed)
        first = FieldProblem(field=field, got=str(got), allowed=allowed)
        self.args = (problems_text(f"{self.noun} {name}", (first, *more)),)


class ScenarioError(ConfigurationError):
    """A scenario with fields that hold what they may not."""

    noun: ClassVar[str] = "scenario"


class UnknownScenarioError(ScenarioError):
    """No shipped scenario has that name, and there is no such file."""

    def __init__(self, name: str, shipped: Sequence[str]) -> None:
        super().__init__(name, "name", repr(name), names_or_file(name, shipped))


class UnreadableScenarioError(ScenarioError):
    """A file that cannot be read as TOML."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(str(path), "file", reason, "a readable TOML file")


class LinkTraceError(ScenarioError):
    """A file that is no trace of packet-delivery times.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path, got: object, allowed: str) -> None:
        self.path = path
        super().__init__("links", f"trace {path}", got, allowed)


def names_or_file(name: str, shipped: Sequence[str]) -> str:
    """Return what is allowed in the place of an unknown name, with the name that was most likely meant."""
    return f"a TOML file or one of {', '.join(shipped)}{suggestion(name, shipped)}"


class RobotCodeError(NotAllowedError):
    """A user's function that returns no robot, or a file without it.

    Attributes:
        source: File and function, or entry point.
    """

    def __init__(self, source: str, got: str, allowed: str, field: str = "function") -> None:
        self.source = source
        self.prefix = f"robot {source}: "
        super().__init__(field, " ".join(got.split()), allowed)
