"""State of a sweep in a file beside its results, for whoever watches from another process."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final, Literal, Self

import psutil
from pydantic import ValidationError

from passafe_services.tools.experiment.schema import Seeds
from passafe_services.tools.runs.record import SweepRecord

SWEEP_FILE: Final = "sweep.json"

Stage = Literal["runs", "logs", "report", "finished", "interrupted"]


class SweepState(SweepRecord):
    """State of a sweep.

    Attributes:
        schema_version: Of the file's format.
        stage: What is done now, or how it ended.
        seeds: Seeds of every cell that were asked for.
        most_runs: Largest number of runs in all.
        pid: Process that sweeps.
        began_s: Unix time at which that process began, s: another one may have its number later.
    """

    schema_version: Literal[1] = 1
    stage: Stage
    seeds: Seeds
    most_runs: int
    pid: int
    began_s: float

    @classmethod
    def read(cls, folder: Path) -> Self | None:
        """Return the state of the sweep in a folder; ``None`` if it has none that can be read."""
        try:
            return cls.model_validate_json((folder / SWEEP_FILE).read_bytes())
        except (OSError, ValidationError):
            return None

    @property
    def runs_on(self) -> bool:
        """True while its process is at it; a sweep whose process was killed has been interrupted."""
        if self.stage in ("finished", "interrupted"):
            return False
        try:
            return bool(psutil.Process(self.pid).create_time() == self.began_s)
        except psutil.Error:
            return False


def state_writer(folder: Path, seeds: Seeds) -> Callable[[Stage, int], None]:
    """Return what writes the state of a sweep of this process: a stage and the largest number of runs.

    Args:
        folder: Folder of the sweep.
        seeds: Seeds of every cell.
    """
    pid = os.getpid()
    began_s = psutil.Process(pid).create_time()

    def write(stage: Stage, most_runs: int) -> None:
        state = SweepState(stage=stage, seeds=seeds, most_runs=most_runs, pid=pid, began_s=began_s)
        unfinished = folder / f"{SWEEP_FILE}.unfinished"
        unfinished.write_text(state.model_dump_json(), encoding="utf-8")
        unfinished.replace(folder / SWEEP_FILE)

    return write
