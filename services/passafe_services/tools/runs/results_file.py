"""Results on disk, a line each: an interrupted sweep resumes where it was."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Generic, Literal, Self, TypeVar

from pydantic import BaseModel, JsonValue, ValidationError

from passafe_services.scenarios.info import versions
from passafe_services.tools.runs.errors import ResultsFileError
from passafe_services.tools.runs.record import SweepRecord

R = TypeVar("R", bound=BaseModel)
K = TypeVar("K", bound=Hashable)


class ResultsHeading(SweepRecord):
    """First line of a results file: what the results are of, and what computed them.

    Attributes:
        schema_version: Of the file's format.
        kind: ``experiment`` or ``campaign``.
        subject: All that decides a result but its own key.
        versions: Of passafe and of what it computes with.
    """

    schema_version: Literal[2]
    kind: str
    subject: dict[str, JsonValue]
    versions: dict[str, str]

    @classmethod
    def of(cls, kind: str, subject: Mapping[str, Any]) -> Self:
        """Return the heading of results that this process computes.

        Args:
            kind: ``experiment`` or ``campaign``.
            subject: What the results are of: plain data.
        """
        return cls(schema_version=2, kind=kind, subject=dict(subject), versions=versions())


class ResultsFile(Generic[K, R]):
    """The results of one sweep in a file.

    Attributes:
        path: The file.
        results: By key.
    """

    def __init__(self, path: Path, heading: ResultsHeading, result_type: type[R], key: Callable[[R], K]) -> None:
        """Open a file, or begin it.

        Args:
            path: The file.
            heading: What its results are of.
            result_type: Model of a result.
            key: Returns the key of a result.

        Raises:
            ResultsFileError: It cannot be read, or holds results of something else, or none.
        """
        self.path = path
        self._key = key
        self.results: dict[K, R] = {}
        if path.exists():
            self._read(heading, result_type)
        else:
            path.write_text(heading.model_dump_json() + "\n", encoding="utf-8")

    def add(self, chunks: Iterable[list[R]]) -> Iterator[list[R]]:
        """Write results as they come, and pass them on."""
        with self.path.open("a", encoding="utf-8") as file:
            for results in chunks:
                file.writelines(result.model_dump_json() + "\n" for result in results)
                file.flush()
                self.results |= {self._key(result): result for result in results}
                yield results

    def _read(self, heading: ResultsHeading, result_type: type[R]) -> None:
        try:
            text = self.path.read_text(encoding="utf-8")
        except OSError as error:
            raise ResultsFileError(self.path, error.strerror or str(error), heading.kind) from error
        whole = text[: text.rfind("\n") + 1]
        try:
            first, *lines = whole.splitlines()
            known = ResultsHeading.model_validate_json(first)
        except (ValueError, ValidationError) as error:
            raise ResultsFileError(self.path, "a file that holds no results of this version", heading.kind) from error
        if known != ResultsHeading.model_validate_json(heading.model_dump_json()):
            raise ResultsFileError(self.path, f"results of another {known.kind} or version", heading.kind)
        try:
            read = [result_type.model_validate_json(line) for line in lines]
        except ValidationError as error:
            raise ResultsFileError(self.path, "a line that is no result", heading.kind) from error
        if whole != text:  # the last line was cut off
            self.path.write_text(whole, encoding="utf-8")
        self.results = {self._key(result): result for result in read}
