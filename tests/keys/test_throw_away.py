"""Throw-away keys: private, found by port, gone at the end."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.errors import KeysUnreadableError
from passafe_services.keys.throw_away import discard_throw_away_keys, throw_away_folder, throw_away_keys


@pytest.fixture(autouse=True)
def _own_temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return


def test_keys_of_a_run_are_found_by_port_until_its_end() -> None:
    with throw_away_keys("arm", 7000) as folder:
        assert folder == throw_away_folder(7000)
        assert load_credentials(folder, "console", "arm").days_left() < 31
        assert not (folder / "authority").exists()  # nobody can issue more
    assert not folder.exists()


def test_keys_of_a_killed_run_are_replaced() -> None:
    left = throw_away_folder(7000) / "plant.old"
    with throw_away_keys("arm", 7000):
        left.mkdir()
        with throw_away_keys("arm", 7000):
            assert not left.exists()
    left.mkdir(parents=True)
    discard_throw_away_keys(7000)
    assert not left.parent.exists()


def test_a_folder_that_others_can_enter_is_refused() -> None:
    parent = throw_away_folder(7000).parent
    parent.mkdir(mode=0o755)
    with (
        pytest.raises(KeysUnreadableError, match="mode 0755, allowed one of yours, 0700"),
        throw_away_keys("arm", 7000),
    ):
        pass


def test_a_link_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    throw_away_folder(7000).parent.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(KeysUnreadableError), throw_away_keys("arm", 7000):
        pass


def test_a_folder_that_cannot_be_made_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    with pytest.raises(KeysUnreadableError, match="cannot be made"), throw_away_keys("arm", 7000):
        pass
