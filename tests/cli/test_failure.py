"""Errors of the operating system, of which none is a defect: one line, and the exit code of what cannot be used."""

import errno
import os
from pathlib import Path

import pytest
from passafe_services.cli.app import app
from passafe_services.cli.failure import REFUSED, run_reporting_errors


@pytest.mark.parametrize("command", ["review", "replay", "whatif", "identify", "recover --out x", "export --csv x"])
@pytest.mark.parametrize("name", ["loop", "a" * 300 + ".mcap"])
def test_a_path_that_cannot_be_followed(
    command: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("loop").symlink_to("loop")
    first, *options = command.split()
    monkeypatch.setattr("sys.argv", ["passafe", first, name, *options])
    with pytest.raises(SystemExit) as ended:
        run_reporting_errors(app)

    said = capsys.readouterr().err
    assert ended.value.code == REFUSED
    assert said.count("\n") == 1
    assert "Too many levels of symbolic links" in said or "File name too long" in said


def test_a_full_disk_behind_what_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    def command() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(SystemExit) as ended:
        run_reporting_errors(command)

    assert ended.value.code == REFUSED  # 1 would say that the run failed
    assert "No space left on device" in capsys.readouterr().err


def test_an_error_that_says_of_no_file_is_a_defect() -> None:
    def command() -> None:
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))

    with pytest.raises(OSError, match="Invalid argument"):
        run_reporting_errors(command)
