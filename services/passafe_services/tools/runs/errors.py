"""Errors of sweeps; the tree of all errors is in ``passafe.errors``."""

from pathlib import Path

from passafe.errors import NotAllowedError, PassafeError


class ResultsFileError(NotAllowedError):
    """A results file from which a sweep cannot resume."""

    def __init__(self, path: Path, got: str, kind: str) -> None:
        super().__init__(str(path), got, f"results of the same {kind}, or no file there")


class WorkerLostError(PassafeError):
    """A worker process that died; every result received before is in the results file."""

    def __init__(self) -> None:
        super().__init__("a worker process died, perhaps out of memory; the same command resumes the sweep")


class SchedulerError(NotAllowedError):
    """A cluster that cannot be used; the field is the address of its scheduler."""

    prefix = "--scheduler "
