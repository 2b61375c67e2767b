"""Errors of scenario files.

* ``ScenarioError``: a field that holds what it may not
    * ``UnknownScenarioError``: no scenario of that name and no such file
    * ``UnreadableScenarioError``: a file that is no TOML
    * ``LinkTraceError``: a file that is no trace of packet-delivery times
"""

from collections.abc import Sequence
from pathlib import Path

from passafe_services.scenarios.field_problems import FieldProblem, problems_text
from passafe_services.suggestion import suggestion


class ScenarioError(Exception):
    """A scenario with fields that hold what they may not.

    Attributes:
        scenario: Its name or file.
        field: Dotted name of the first of them.
        got: What it holds.
        allowed: What is allowed, in words.
    """

    def __init__(self, scenario: str, field: str, got: object, allowed: str, *more: FieldProblem) -> None:
        self.scenario = scenario
        self.field = field
        self.got = got
        self.allowed = allowed
        first = FieldProblem(field=field, got=str(got), allowed=allowed)
        super().__init__(problems_text(f"scenario {scenario}", (first, *more)))


class UnknownScenarioError(ScenarioError):
    """No shipped scenario has that name, and there is no such file."""

    def __init__(self, name: str, shipped: Sequence[str]) -> None:
        super().__init__(
            name, "name", repr(name), f"a TOML file or one of {', '.join(shipped)}{suggestion(name, shipped)}"
        )


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
