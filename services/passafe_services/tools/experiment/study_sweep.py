"""The sweep of a study in a folder: runs, results, logs and state, resumed from where they are."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Final

from passafe_services.tools.experiment.cells import Run
from passafe_services.tools.experiment.kept_list import KeptList
from passafe_services.tools.experiment.kept_logs import Keep, KeptLog, LogJob, chosen
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult, experiment_results
from passafe_services.tools.experiment.study_job import StudyJob, chunk_size
from passafe_services.tools.experiment.sweep_state import Stage, state_writer
from passafe_services.tools.runs.sweep import FixedPlan, sweep
from passafe_services.tools.runs.workers import Workers

RESULTS_FILE: Final = "results.jsonl"


class StudySweep:
    """Sweep of a study, as far as its folder holds it. Workers are the caller's.

    Args:
        study: The study.
        folder: An existing folder.

    Attributes:
        study: The study.
        folder: The folder.
        plan: The runs that are wanted, and the results.

    Raises:
        ResultsFileError: The folder holds results of something else.
    """

    def __init__(self, study: Study, folder: Path) -> None:
        self.study = study
        self.folder = folder
        self._results = experiment_results(folder / RESULTS_FILE, study)
        self._kept = KeptList(folder)
        self._write_state = state_writer(folder, study.experiment.seeds)
        self.plan = Plan(study.experiment, self._results.results)

    @property
    def errors(self) -> int:
        """Number of runs that could not be run."""
        return sum(bool(result.error) for result in self.plan.results.values())

    def note(self, stage: Stage) -> None:
        """Write down what is done now, for whoever watches the folder."""
        known = len(self.plan.results)
        self._write_state(stage, self.plan.most_runs if stage in ("runs", "interrupted") else known)

    @contextmanager
    def noting_an_interruption(self) -> Iterator[None]:
        """Write down that the sweep was interrupted if the block does not end."""
        try:
            yield
        except BaseException:
            self.note("interrupted")
            raise

    def run_job(self) -> StudyJob:
        """Return what workers for its runs work for."""
        return StudyJob.of(self.study)

    def run(self, workers: Workers[Run, RunResult], stop: Callable[[], bool]) -> Iterator[list[RunResult]]:
        """Run what is wanted; yield results chunk by chunk, each when it is written.

        Args:
            workers: Who runs.
            stop: Whether to end at once.

        Raises:
            WorkerLostError: A worker process died.
        """
        return self._results.add(sweep(self.plan, workers, partial(chunk_size, workers=workers.count), stop))

    def log_job(self) -> LogJob:
        """Return what workers for its logs work for."""
        return LogJob.of(self.study, self.folder / "logs")

    def worth_a_log(self, keep: Keep, most: int) -> list[RunResult]:
        """Return the runs of which there should be a log, the worst first, no more than ``most``."""
        return chosen(self.plan, keep, most)

    def without_log(self, wanted: list[RunResult]) -> list[RunResult]:
        """Return those of some runs of which there is no log yet."""
        return [result for result in wanted if self._kept.find(result) is None]

    def write_logs(
        self, missing: list[RunResult], workers: Workers[RunResult, KeptLog], stop: Callable[[], bool]
    ) -> Iterator[list[KeptLog]]:
        """Write the logs of some runs; yield those that are whole, each when it is noted.

        Args:
            missing: The runs.
            workers: Who writes; the folder of logs exists.
            stop: Whether to end at once.

        Raises:
            WorkerLostError: A worker process died.
        """
        for logs in sweep(FixedPlan(missing), workers, lambda _: 1, stop):
            self._kept.add(logs)
            yield logs

    def logs_of(self, wanted: list[RunResult]) -> list[KeptLog]:
        """Return the logs that there are of some runs, in their order."""
        return [log for result in wanted if (log := self._kept.find(result)) is not None]
