"""Results on disk, a line each: an interrupted sweep goes on where it was."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from pydantic import BaseModel, ConfigDict, JsonValue, ValidationError

from passafe_services.scenarios.info import versions
from passafe_services.tools.experiment.errors import ResultsFileError
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.runs import Result, RunKey
from passafe_services.tools.experiment.schema import Experiment, Seeds


class ResultsHeading(BaseModel):
    """First line of a file: what the results in it are of, and what computed them.

    More seeds may be asked for later: how many there are is left out.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    experiment: Experiment
    scenario: dict[str, JsonValue]
    versions: dict[str, str]

    @classmethod
    def of(cls, study: Study) -> "ResultsHeading":
        """Return the heading of a study's results."""
        experiment = study.experiment.model_copy(update={"seeds": Seeds(), "title": "", "description": ""})
        return cls(experiment=experiment, scenario=study.scenario, versions=versions())


class ResultsFile:
    """The results of one experiment in a file.

    Attributes:
        path: The file.
        results: By key.
    """

    def __init__(self, path: Path, study: Study) -> None:
        """Open a file, or begin it.

        Raises:
            ResultsFileError: It holds another experiment's results, or no results.
        """
        self.path = path
        self.results: dict[RunKey, Result] = {}
        heading = ResultsHeading.of(study)
        if path.exists():
            self._read(heading)
        else:
            path.write_text(heading.model_dump_json() + "\n", encoding="utf-8")

    def add(self, results: Iterable[Result]) -> Iterator[Result]:
        """Write results down as they come, and pass them on."""
        with self.path.open("a", encoding="utf-8") as file:
            for result in results:
                file.write(result.model_dump_json() + "\n")
                file.flush()
                self.results[result.run.key] = result
                yield result

    def _read(self, heading: ResultsHeading) -> None:
        text = self.path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        try:
            first, *lines = whole.splitlines()
            known = ResultsHeading.model_validate_json(first)
            read = [Result.model_validate_json(line) for line in lines]
        except (ValueError, ValidationError) as error:
            raise ResultsFileError(self.path, "a file that holds no results of this version") from error
        if known != heading:
            raise ResultsFileError(self.path, "the results of another experiment, scenario or version")
        if whole != text:  # the last line was cut off
            self.path.write_text(whole, encoding="utf-8")
        self.results = {result.run.key: result for result in read}
