"""List of the logs that were written of an experiment's runs: none is written twice after an interruption."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from passafe_services.tools.experiment.cells import RunKey
from passafe_services.tools.experiment.kept_logs import KeptLog
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.runs.record import SweepRecord

NAME: Final = "kept.jsonl"


class _Line(SweepRecord):
    """One log that was written whole.

    Attributes:
        key: Run that it is of.
        wall_s: Time that the run took in the sweep: another run of the same key took another time.
        file: Its path within the experiment's folder.
        differing: Metrics of which review and sweep disagreed.
    """

    key: RunKey
    wall_s: float
    file: str
    differing: tuple[str, ...]


class KeptList:
    """Logs of one experiment.

    Args:
        folder: Folder of the experiment.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / NAME
        self._folder = folder
        self._lines: dict[RunKey, _Line] = {}
        with suppress(OSError):  # there is none yet
            for text in self.path.read_text(encoding="utf-8").splitlines():
                with suppress(ValidationError):  # an interruption cut a line off
                    line = _Line.model_validate_json(text)
                    self._lines[line.key] = line

    def find(self, result: RunResult) -> KeptLog | None:
        """Return the log of a run; ``None`` if none was written whole, or if it is gone."""
        line = self._lines.get(result.run.key)
        if line is None or line.wall_s != result.wall_s or not (self._folder / line.file).is_file():
            return None
        return KeptLog(result, self._folder / line.file, line.differing)

    def add(self, logs: Sequence[KeptLog]) -> None:
        """Note logs that were written whole."""
        with self.path.open("a", encoding="utf-8") as file:
            for log in logs:
                result = log.result
                path = log.path.relative_to(self._folder).as_posix()
                line = _Line(key=result.run.key, wall_s=result.wall_s, file=path, differing=log.differing)
                self._lines[line.key] = line
                file.write(f"\n{line.model_dump_json()}\n")  # begins a line also where one was cut off
