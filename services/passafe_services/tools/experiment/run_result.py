"""The result of one run, and the file that holds those of a study."""

from pathlib import Path

from passafe_services.tools.experiment.cells import Run, RunKey
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.experiment.schema import Seeds
from passafe_services.tools.runs.record import SweepRecord
from passafe_services.tools.runs.results_file import ResultsFile, ResultsHeading


class RunResult(SweepRecord):
    """The result of one run.

    Attributes:
        run: The run.
        metrics: Its metrics; ``None`` if it ended with an error.
        error: Why it could not be run, in words; empty if it could.
        wall_s: Time that it took, s: the only number that another time differs.
    """

    run: Run
    metrics: Metrics | None
    error: str = ""
    wall_s: float


def experiment_results(path: Path, study: Study) -> ResultsFile[RunKey, RunResult]:
    """Open the results file of a study, or begin it.

    More seeds may be asked for later, and other words be used: none of that is in its heading.

    Raises:
        ResultsFileError: It holds results of something else, or no results.
    """
    experiment = study.experiment.model_copy(update={"seeds": Seeds(), "title": "", "description": ""})
    subject = {"experiment": experiment.model_dump(mode="json"), "scenario": study.scenario}
    return ResultsFile(path, ResultsHeading.of("experiment", subject), RunResult, lambda result: result.run.key)
