"""List the experiments that can be started: those that come with passafe, and files in the runs folder."""

import tomllib
from pathlib import Path
from typing import Final, Literal

from passafe_services.scenarios.bounded_file import require_bounded
from passafe_services.tools.experiment.cells import cells_of
from passafe_services.tools.experiment.load import EXAMPLES, experiment_from, shipped_experiments
from passafe_services.tools.experiment.plan import Plan

from passafe.errors import PassafeError
from passafe_dashboard.archive.experiment_models import ExperimentOffer, ExperimentOffers
from passafe_dashboard.archive.runs_folder import RunsFolder

MOST_RUNS: Final = 5_000
"""Runs of the largest experiment that the page starts."""

MOST_FILES: Final = 100
MOST_FILE_BYTES: Final = 1 << 20


class OfferLister:
    """Lists experiments; a file is read once while it does not change. Call from a worker thread: it reads files.

    Args:
        folder: The runs folder.
    """

    def __init__(self, folder: RunsFolder) -> None:
        self._folder = folder
        self._files: dict[tuple[Path, int, int], ExperimentOffer | None] = {}
        self._shipped = tuple(
            _offer("shipped", name, (EXAMPLES / f"{name}.toml").read_text("utf-8")) for name in shipped_experiments()
        )

    def all(self) -> ExperimentOffers:
        """Return the shipped experiments, then those in the runs folder."""
        found = (self._of_file(name) for name in sorted(self._folder.toml_files())[:MOST_FILES])
        offers = (offer for offer in (*self._shipped, *found) if offer is not None)
        return ExperimentOffers(offers=tuple(offers), most_runs=MOST_RUNS)

    def _of_file(self, name: str) -> ExperimentOffer | None:
        path = self._folder.root / name
        try:
            require_bounded(path, MOST_FILE_BYTES)
            stat = path.stat()
            key = (path, stat.st_size, stat.st_mtime_ns)
            if key not in self._files:
                if len(self._files) >= 4 * MOST_FILES:
                    self._files.clear()
                self._files[key] = _offer("file", name, path.read_text("utf-8"))
            return self._files[key]
        except (OSError, UnicodeDecodeError):
            return None


def _offer(source: Literal["shipped", "file"], name: str, text: str) -> ExperimentOffer | None:
    """Return what is offered of a file; ``None`` if it holds something else, such as a scenario."""
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError):
        return None
    if not isinstance(data.get("scenario"), str):
        return None
    try:
        experiment = experiment_from(data, name)
    except PassafeError as error:
        title = str(data.get("title", ""))[:200]
        return ExperimentOffer(
            source=source, experiment=name, title=title, cells=0, seeds=0, most_runs=0, trouble=str(error)
        )
    return ExperimentOffer(
        source=source,
        experiment=name,
        title=experiment.title,
        cells=len(cells_of(experiment)),
        seeds=experiment.seeds.count,
        most_runs=Plan(experiment).most_runs,
        trouble="",
    )
