"""Logs that appear under their name when they are whole, and what stood there before until then."""

from pathlib import Path

import pytest
from passafe_services.cli import simulate
from passafe_services.cli.app import app
from passafe_services.log.log_file import in_place_of
from typer.testing import CliRunner


def test_an_error_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_text("before")

    def write() -> None:
        with in_place_of(path, replace=True) as unfinished:
            unfinished.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write()

    assert path.read_text() == "before"
    assert [*tmp_path.iterdir()] == [path]


def test_a_link_leads_to_what_was_written(tmp_path: Path) -> None:
    (tmp_path / "run.mcap").write_text("before")
    (tmp_path / "link").symlink_to("run.mcap")
    with in_place_of(tmp_path / "link", replace=True) as unfinished:
        unfinished.write_text("after")

    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "run.mcap").read_text() == "after"


def test_an_interrupted_simulation_leaves_no_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(simulate, "lockstep_loop", interrupt)
    CliRunner().invoke(app, ["simulate", "--duration", "0.1", "--out", str(tmp_path / "run.mcap")])

    assert [*tmp_path.iterdir()] == []
