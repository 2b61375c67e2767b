"""Errors of experiments; the tree of all errors is in ``passafe.errors``."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from passafe.errors import NotAllowedError, PassafeError
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


class ResultsFileError(NotAllowedError):
    """A file of results that a sweep cannot resume from."""

    def __init__(self, path: Path, got: str) -> None:
        super().__init__(str(path), got, "the same experiment's results, or no file there")


class WorkerLostError(PassafeError):
    """A worker process that is gone; what was finished is written down."""

    def __init__(self) -> None:
        super().__init__("a worker process died, perhaps for want of memory; the same command goes on where it was")


class SchedulerError(NotAllowedError):
    """A cluster that cannot be used; the field is the address of its scheduler."""

    prefix = "--scheduler "


class LiveRunError(NotAllowedError):
    """A live run that left no log, or not to its end; the field is the file with what was run."""

    prefix = "live run of "

    def __init__(self, scenario: Path, got: str) -> None:
        super().__init__(str(scenario), got, "a run that writes its log to the end")
