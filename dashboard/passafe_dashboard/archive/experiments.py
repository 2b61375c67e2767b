"""Follow the experiments in the runs folder, each from where the last look ended."""

from typing import Final

from passafe_dashboard.archive.experiment_models import ExperimentList, ExperimentView
from passafe_dashboard.archive.experiment_view import entry_of, view_of
from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.archive.sweep_reader import SweepReader
from passafe_dashboard.errors import ArchiveNameError

MOST_EXPERIMENTS: Final = 100


class Experiments:
    """Experiments of a folder. Call from a worker thread: it reads files.

    Args:
        folder: The folder.
    """

    def __init__(self, folder: RunsFolder) -> None:
        self._folder = folder
        self._sweeps: dict[str, SweepReader] = {}

    def newest(self) -> ExperimentList:
        """Return the experiments, the newest first."""
        names = self._folder.experiments()[:MOST_EXPERIMENTS]
        for gone in self._sweeps.keys() - set(names):
            del self._sweeps[gone]
        entries = [entry_of(name, self._folder.root / name, self._looked(name)) for name in names]
        return ExperimentList(experiments=tuple(sorted(entries, key=lambda entry: entry.modified_s, reverse=True)))

    def view(self, name: str) -> ExperimentView:
        """Return the map of an experiment, as far as it has come.

        Raises:
            ArchiveNameError: There is no such experiment in the folder, or its results cannot be read.
        """
        folder = self._folder.experiment(name)
        reader = self._looked(name)
        found = view_of(name, folder, reader)
        if found is None:
            raise ArchiveNameError("experiment", name, f"one whose results can be read ({reader.trouble})")
        return found

    def _looked(self, name: str) -> SweepReader:
        """Return the reader of an experiment after another look."""
        reader = self._sweeps.setdefault(name, SweepReader(self._folder.root / name))
        reader.look()
        return reader
