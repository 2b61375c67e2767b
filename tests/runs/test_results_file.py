"""Results files: what is written, resumed and refused."""

import json
from pathlib import Path

import pytest
from passafe_services.tools.runs.errors import ResultsFileError
from passafe_services.tools.runs.results_file import ResultsFile, ResultsHeading
from pydantic import BaseModel


class Number(BaseModel):
    """A result."""

    seed: int
    value: float


HEADING = ResultsHeading.of("campaign", {"scenario": "one", "duration_s": 0.1})


def opened(path: Path, heading: ResultsHeading = HEADING) -> ResultsFile[int, Number]:
    return ResultsFile(path, heading, Number, lambda number: number.seed)


def numbers(*seeds: int) -> list[Number]:
    return [Number(seed=seed, value=seed / 3) for seed in seeds]


def test_an_interrupted_sweep_resumes_without_the_cut_line(tmp_path: Path) -> None:
    path = tmp_path / "r.jsonl"
    assert len(list(opened(path).add([numbers(0), numbers(1, 3)]))) == 2
    with path.open("a", encoding="utf-8") as file:
        file.write('{"seed": 2, "val')  # killed while it wrote

    again = opened(path)
    assert again.results == {number.seed: number for number in numbers(0, 1, 3)}
    list(again.add([numbers(2)]))
    assert sorted(opened(path).results) == [0, 1, 2, 3]


def test_every_chunk_is_on_disk_before_it_is_passed_on(tmp_path: Path) -> None:
    path = tmp_path / "r.jsonl"

    for count, _ in enumerate(opened(path).add([numbers(0), numbers(1)]), start=1):
        assert path.read_text(encoding="utf-8").count("\n") == 1 + count


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("experiment", {"kind": "experiment"}),
        ("campaign", {"subject": HEADING.subject | {"duration_s": 0.2}}),
        ("campaign", {"versions": HEADING.versions | {"numpy": "0.1"}}),
    ],
)
def test_results_of_something_else_are_refused(kind: str, changes: dict[str, object], tmp_path: Path) -> None:
    opened(tmp_path / "r.jsonl", HEADING.model_copy(update=changes))

    with pytest.raises(ResultsFileError, match=f"got results of another {kind} or version, allowed .* same campaign"):
        opened(tmp_path / "r.jsonl")


@pytest.mark.parametrize("first", ["nonsense", "", json.dumps({"scenario": {}, "duration_s": 1.0})])
def test_a_file_without_a_heading_of_this_version_is_refused(first: str, tmp_path: Path) -> None:
    (tmp_path / "r.jsonl").write_text(f"{first}\n", encoding="utf-8")

    with pytest.raises(ResultsFileError, match="no results of this version"):
        opened(tmp_path / "r.jsonl")


def test_a_line_that_is_no_result_is_refused(tmp_path: Path) -> None:
    opened(tmp_path / "r.jsonl")
    with (tmp_path / "r.jsonl").open("a", encoding="utf-8") as file:
        file.write("{}\n")

    with pytest.raises(ResultsFileError, match="a line that is no result"):
        opened(tmp_path / "r.jsonl")
