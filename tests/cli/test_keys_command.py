"""``passafe keys``, and how commands come by their keys."""

import tempfile
from pathlib import Path

import pytest
from passafe_services.cli.access_options import secured_endpoint
from passafe_services.cli.app import app
from passafe_services.cli.errors import OptionError
from passafe_services.keys.errors import KeysExistError, KeysMissingError
from passafe_services.keys.throw_away import throw_away_keys
from typer.testing import CliRunner


def keys(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["keys", *arguments], catch_exceptions=False)
    return done.exit_code, done.output


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    assert keys("make", str(tmp_path / "keys"), "--robot", "arm", "--operator", "ann")[0] == 0
    return tmp_path / "keys"


def test_a_deployment_is_made_shown_and_kept(folder: Path) -> None:
    code, text = keys("show", str(folder))
    assert code == 0
    assert "operator.arm.ann" in text
    assert keys("make", str(folder), "--if-missing") == (0, f"{folder} has keys\n")
    with pytest.raises(KeysExistError):
        keys("make", str(folder))


def test_people_and_robots_come_and_go(folder: Path) -> None:
    assert keys("add", str(folder), "--operator", "ben") == (0, "added operator.arm.ben\n")
    assert "added plant.leg\n" in keys("add", str(folder), "--robot", "leg")[1]
    with pytest.raises(OptionError, match="allowed a new robot or a new person"):
        keys("add", str(folder))
    assert keys("remove", str(folder), "operator.arm.ben")[0] == 0
    admitted = (folder / "router" / "admitted.txt").read_text().split()
    assert "plant.leg" in admitted
    assert "operator.arm.ben" not in admitted


def test_what_expires_soon_shows_in_text_and_exit_code(folder: Path) -> None:
    assert keys("renew", str(folder), "--days", "3")[0] == 0
    code, text = keys("show", str(folder))
    assert code == 1
    assert ", 3.0 days" in text


def test_insecure_says_what_it_gives_up(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert secured_endpoint("127.0.0.1:7000", "plant", "arm", keys=None, insecure=True).credentials is None
    said = capsys.readouterr().err
    assert "insecure: whoever reaches 127.0.0.1:7000 can" in said
    assert "nothing is encrypted" in said
    with pytest.raises(OptionError, match="allowed one of them"):
        secured_endpoint("127.0.0.1:7000", "plant", "arm", keys=folder, insecure=True)


def test_keys_are_given_or_those_of_a_demo_here(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(OptionError, match="--keys: got none, and no demo of yours"):
        secured_endpoint("127.0.0.1:7000", "plant", "arm", keys=None, insecure=False)
    with throw_away_keys("arm", 7000):
        assert secured_endpoint("localhost:7000", "plant", "arm", keys=None, insecure=False).locator.startswith("tls/")
        with pytest.raises(OptionError):
            secured_endpoint("192.0.2.7:7000", "plant", "arm", keys=None, insecure=False)
        with pytest.raises(KeysMissingError, match=r"console\.leg"):
            secured_endpoint("127.0.0.1:7000", "console", "leg", keys=None, insecure=False)
    keys("renew", str(folder), "--days", "3")
    secured_endpoint("127.0.0.1:7000", "plant", "arm", keys=folder, insecure=False)
    assert "certificate of plant.arm expires in 3.0 days" in capsys.readouterr().err
