"""The runs of one study, as workers see them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Self

from passafe_services.tools.experiment.cells import Run
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.runner import StudyRunner

CHUNK: Final = 4
"""Runs that a worker takes at a time, at most; they share what is compiled and their reference."""

LEAST_CHUNKS: Final = 8
"""Chunks for each worker that there should be, so that all of them end at about the same time."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StudyJob:
    """All that the runs of a study have in common; a task is a run.

    Attributes:
        study_json: The study.
    """

    study_json: str

    @classmethod
    def of(cls, study: Study) -> Self:
        """Return the job of a study."""
        return cls(study_json=study.model_dump_json())

    def compile(self) -> Callable[[Sequence[Run]], list[RunResult]]:
        """Return the function from runs to their results."""
        runner = StudyRunner(Study.model_validate_json(self.study_json))
        return lambda runs: [runner.result(run) for run in runs]


def chunk_size(waiting: int, workers: int) -> int:
    """Return how many runs the next chunk has.

    Args:
        waiting: How many runs wait.
        workers: How many workers there are.
    """
    return min(CHUNK, -(-waiting // (LEAST_CHUNKS * workers)))
