from importlib import import_module
from pathlib import Path

import pytest
from passafe_services.cli import export
from passafe_services.cli.app import app
from passafe_services.cli.errors import OptionError
from small_log import small_log
from typer.testing import CliRunner

from passafe.errors import MissingPackageError


def test_writes_every_format_that_is_asked_for(tmp_path: Path) -> None:
    log = small_log(tmp_path / "run.mcap")
    words = ["export", str(log), "--csv", str(tmp_path / "csv"), "--parquet", str(tmp_path / "parquet")]

    result = CliRunner().invoke(app, words)

    assert result.exit_code == 0, result.output
    assert (tmp_path / "csv" / "state.csv").exists()
    assert str(tmp_path / "parquet" / "tick.parquet") in result.output


def test_a_torn_log_is_exported_and_said_to_be_torn(tmp_path: Path) -> None:
    log = small_log(tmp_path / "run.mcap")
    log.write_bytes(log.read_bytes()[:-40])

    result = CliRunner().invoke(app, ["export", str(log), "--csv", str(tmp_path)])

    assert result.exit_code == 0
    assert "torn" in result.output


def test_without_a_format_it_names_them(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["export", str(small_log(tmp_path / "run.mcap"))])

    assert isinstance(result.exception, OptionError)
    assert "--csv, --parquet, --foxglove, --ros2" in str(result.exception)


def test_names_the_extra_that_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(name: str) -> None:
        raise ModuleNotFoundError(name, name="pyarrow.lib")

    log = small_log(tmp_path / "run.mcap")
    import_module("passafe_services.tools.export.csv_tables")
    monkeypatch.setattr(export, "import_module", refuse)

    result = CliRunner().invoke(app, ["export", str(log), "--parquet", str(tmp_path)])

    assert isinstance(result.exception, MissingPackageError)
    assert str(result.exception) == "no package 'pyarrow': install it with pip install 'passafe[service]'"
