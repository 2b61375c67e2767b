"""Errors of experiments; the tree of all errors is in ``passafe.errors``."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from passafe.errors import NotAllowedError
from passafe_services.scenarios.errors import ConfigurationError, names_or_file


class ExperimentError(ConfigurationError):
    """An experiment with fields that hold what they may not."""

    noun: ClassVar[str] = "experiment"


class UnknownExperimentError(ExperimentError):
    """No shipped experiment has that name, and there is no such file."""

    def __init__(self, name: str, shipped: Sequence[str]) -> None:
        super().__init__(name, "name", repr(name), names_or_file(name, shipped))


class UnreadableExperimentError(ExperimentError):
    """A file that cannot be read as TOML."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(str(path), "file", reason, "a readable TOML file")


class LiveRunError(NotAllowedError):
    """A live run that left no log, or not to its end; the field is the file with what was run."""

    prefix = "live run of "

    def __init__(self, scenario: Path, got: str) -> None:
        super().__init__(str(scenario), got, "a run that writes its log to the end")
