"""Read the results of a sweep while it runs: what was added since the last look, a bounded amount at a time."""

from pathlib import Path
from typing import Final

from passafe_services.tools.experiment.schema import Experiment
from passafe_services.tools.runs.results_file import ResultsHeading
from pydantic import ValidationError

from passafe_dashboard.archive.runs_folder import RESULTS
from passafe_dashboard.archive.sweep_tally import SweepTally

MOST_BYTES: Final = 4 << 20
"""Bytes of a results file that one look takes in: a few thousand results."""

LONGEST_HEADING_BYTES: Final = 2 << 20


class SweepReader:
    """Results of one sweep, read so far. Call from a worker thread: it reads files.

    Args:
        folder: Folder of the experiment.

    Attributes:
        tally: The results, counted; ``None`` while there are none that can be read.
        trouble: Why they cannot be read, in words; empty if they can.
        is_behind: Whether there are results that have not been read yet.
    """

    def __init__(self, folder: Path) -> None:
        self.tally: SweepTally | None = None
        self.trouble = ""
        self.is_behind = False
        self._path = folder / RESULTS
        self._file = (0, 0)  # device and number of the file that was read
        self._read = 0

    def look(self) -> None:
        """Read what was added; begin anew if the file was replaced."""
        try:
            stat = self._path.stat()
            if self._file != (stat.st_dev, stat.st_ino) or stat.st_size < self._read:
                self._begin()
                self._file = (stat.st_dev, stat.st_ino)
            if self.tally is not None:
                self._take(self.tally)
        except OSError as error:
            self.tally, self.trouble = None, error.strerror or str(error)

    def _begin(self) -> None:
        self.tally, self.trouble, self._read = None, "", 0
        with self._path.open("rb") as file:
            line = file.readline(LONGEST_HEADING_BYTES)
        try:
            heading = ResultsHeading.model_validate_json(line)
            experiment = Experiment.model_validate(heading.subject["experiment"])
        except (ValidationError, KeyError):
            self.trouble = "not the results of an experiment of this version"
            return
        self._read = len(line)
        self.tally = SweepTally(experiment)

    def _take(self, tally: SweepTally) -> None:
        with self._path.open("rb") as file:
            file.seek(self._read)
            text = file.read(MOST_BYTES)
            self.is_behind = len(text) == MOST_BYTES
        whole = text[: text.rfind(b"\n") + 1]
        self._read += len(whole)
        for line in whole.splitlines():
            try:
                tally.add(line)
            except ValueError:
                self.trouble = "a line of its results cannot be read"
