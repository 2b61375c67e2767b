"""Names in the runs folder: what can be opened by one, and that none leads out of the folder."""

import os
from pathlib import Path

import pytest
from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.errors import ArchiveNameError


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Return a runs folder with logs of all kinds, and a log beside it."""
    runs = tmp_path / "runs"
    (runs / "delay" / "logs").mkdir(parents=True)
    for name in ("a.mcap", "with space (1).mcap", "delay/logs/cell-0-seed-1.mcap", ".hidden.mcap", "notes.txt"):
        (runs / name).touch()
    (runs / "delay" / "results.jsonl").touch()
    (tmp_path / "outside.mcap").touch()
    (runs / "inside-link.mcap").symlink_to("a.mcap")
    (runs / "outside-link.mcap").symlink_to(tmp_path / "outside.mcap")
    (runs / "loop.mcap").symlink_to("loop.mcap")
    (runs / "linked").symlink_to(tmp_path)
    os.mkfifo(runs / "pipe.mcap")
    return runs


def test_logs_are_found_in_the_folder_and_below(root: Path) -> None:
    assert sorted(RunsFolder(root).logs()) == [
        "a.mcap",
        "delay/logs/cell-0-seed-1.mcap",
        "inside-link.mcap",
        "with space (1).mcap",
    ]
    assert RunsFolder(root).experiments() == ["delay"]


@pytest.mark.parametrize("name", ["a.mcap", "with space (1).mcap", "inside-link.mcap", "delay/logs/cell-0-seed-1.mcap"])
def test_a_listed_log_has_a_path(root: Path, name: str) -> None:
    assert RunsFolder(root).log(name) == root / name


@pytest.mark.parametrize(
    "name",
    [
        *("", "b.mcap", "/etc/passwd", "../outside.mcap", "delay/../a.mcap", "delay/../../outside.mcap", "./a.mcap"),
        *("outside-link.mcap", "linked/outside.mcap", "loop.mcap", "pipe.mcap", "delay", "delay//logs", ".hidden.mcap"),
        *("notes.txt", "a.mcap\0", "a\0/b.mcap", "\ud800.mcap", "x" * 2000 + ".mcap", "a.mcap/", "~/a.mcap"),
    ],
)
def test_no_other_name_leads_anywhere(root: Path, name: str) -> None:
    with pytest.raises(ArchiveNameError, match="log: got"):
        RunsFolder(root).log(name)


@pytest.mark.parametrize("name", ["", "..", "delay/logs", "linked", "/delay", "delay/../delay"])
def test_a_folder_without_results_is_no_experiment(root: Path, name: str) -> None:
    assert RunsFolder(root).experiment("delay") == root / "delay"
    with pytest.raises(ArchiveNameError, match="experiment: got"):
        RunsFolder(root).experiment(name)


def test_a_folder_that_is_not_there_yet_is_empty(tmp_path: Path) -> None:
    folder = RunsFolder(tmp_path / "later")
    assert folder.logs() == []
    with pytest.raises(ArchiveNameError):
        folder.log("a.mcap")


def test_a_name_that_is_no_text_is_left_out(root: Path) -> None:
    (Path(os.fsdecode(os.fsencode(root) + b"/\xff.mcap"))).touch()
    assert len(RunsFolder(root).logs()) == 4


def test_folders_are_looked_into_four_deep(tmp_path: Path) -> None:
    deep = tmp_path / "1" / "2" / "3" / "4"
    (deep / "5").mkdir(parents=True)
    (deep / "a.mcap").touch()
    (deep / "5" / "b.mcap").touch()
    assert RunsFolder(tmp_path).logs() == ["1/2/3/4/a.mcap"]
