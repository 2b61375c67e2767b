"""Bags of ROS 2 take the place of bags alone: a folder that holds anything else is left as it is."""

from pathlib import Path

import pytest
from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.errors import ExportError
from passafe_services.tools.export.ros2_bag import write_ros2
from small_log import small_log


@pytest.fixture
def scan(tmp_path: Path) -> LogScan:
    return LogScan.of(small_log(tmp_path / "run.mcap"))


@pytest.mark.parametrize("name", ["precious.txt", "metadata.yml", "bag.mcap"])
def test_a_folder_with_something_else_is_kept(scan: LogScan, name: str, tmp_path: Path) -> None:
    kept = tmp_path / "bag" / name
    kept.parent.mkdir()
    kept.write_text("kept")
    with pytest.raises(ExportError, match=f"it holds {name}, which is not of a bag"):
        write_ros2(scan, kept.parent)

    assert kept.read_text() == "kept"


def test_what_was_put_beside_a_bag_is_kept(scan: LogScan, tmp_path: Path) -> None:
    write_ros2(scan, tmp_path / "bag")
    (tmp_path / "bag" / "notes").touch()
    with pytest.raises(ExportError, match="notes"):
        write_ros2(scan, tmp_path / "bag")


def test_a_bag_is_replaced(scan: LogScan, tmp_path: Path) -> None:
    for _ in range(2):
        write_ros2(scan, tmp_path / "bag")

    assert {each.name for each in (tmp_path / "bag").iterdir()} == {"metadata.yaml", "bag.mcap"}


def test_the_working_folder_has_a_name(scan: LogScan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    write_ros2(scan, Path())

    assert (tmp_path / "here" / "here.mcap").exists()
