"""Errors of experiments.

* ``ExperimentError``: a file that holds what it may not
    * ``UnknownExperimentError``: no experiment of that name and no such file
    * ``UnreadableExperimentError``: a file that is no TOML
* ``SweepError``: what keeps a sweep from going on
    * ``ResultsFileError``: a file of results that cannot be gone on with
    * ``WorkerLostError``: a worker process that is gone
    * ``SchedulerError``: a cluster that cannot be used
    * ``LiveRunError``: a live run without a log
"""

from collections.abc import Sequence
from pathlib import Path

from passafe_services.scenarios.field_problems import FieldProblem, problems_text
from passafe_services.suggestion import suggestion


class ExperimentError(Exception):
    """An experiment with fields that hold what they may not.

    Attributes:
        experiment: Its name or file.
        field: Dotted name of the first of them.
        got: What it holds.
        allowed: What is allowed, in words.
    """

    def __init__(self, experiment: str, field: str, got: object, allowed: str, *more: FieldProblem) -> None:
        self.experiment = experiment
        self.field = field
        self.got = got
        self.allowed = allowed
        first = FieldProblem(field=field, got=str(got), allowed=allowed)
        super().__init__(problems_text(f"experiment {experiment}", (first, *more)))


class UnknownExperimentError(ExperimentError):
    """No shipped experiment has that name, and there is no such file."""

    def __init__(self, name: str, shipped: Sequence[str]) -> None:
        super().__init__(
            name, "name", repr(name), f"a TOML file or one of {', '.join(shipped)}{suggestion(name, shipped)}"
        )


class UnreadableExperimentError(ExperimentError):
    """A file that cannot be read as TOML."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(str(path), "file", reason, "a readable TOML file")


class SweepError(Exception):
    """What keeps a sweep from going on."""


class ResultsFileError(SweepError):
    """A file of results that cannot be gone on with.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path, got: str) -> None:
        self.path = path
        super().__init__(f"{path}: got {got}, allowed the same experiment's results, or no file there")


class WorkerLostError(SweepError):
    """A worker process that is gone; what was finished is written down."""

    def __init__(self) -> None:
        super().__init__("a worker process died, perhaps for want of memory; the same command goes on where it was")


class SchedulerError(SweepError):
    """A cluster that cannot be used.

    Attributes:
        address: Of its scheduler.
    """

    def __init__(self, address: str, got: str, allowed: str) -> None:
        self.address = address
        super().__init__(f"--scheduler {address}: got {got}, allowed {allowed}")


class LiveRunError(SweepError):
    """A live run that left no log, or not to its end.

    Attributes:
        scenario: File with what was run.
    """

    def __init__(self, scenario: Path, got: str) -> None:
        self.scenario = scenario
        super().__init__(f"live run of {scenario}: got {got}, allowed a run that writes its log to the end")
