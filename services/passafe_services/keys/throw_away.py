"""Throw-away keys: made for one run on this host, in a folder that only this user can enter."""

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.keys.errors import KeysUnreadableError
from passafe_services.keys.key_files import FOLDER_MODE

THROW_AWAY_DAYS: Final = 30.0
"""How long throw-away keys are valid: a run that lasts longer needs keys of a deployment."""


def throw_away_folder(router_port: int) -> Path:
    """Return where the keys of the run whose router listens at a port of this host are, if there is one.

    Other processes of the same user find them there without an option.
    """
    return _private_folder() / str(router_port)


@contextmanager
def throw_away_keys(robot: str, router_port: int) -> Iterator[Path]:
    """Make the keys of one robot and its router, and delete them at the end of the block.

    Args:
        robot: The robot.
        router_port: Port of the router; keys that an earlier run left there are replaced.

    Raises:
        KeysUnreadableError: The folder cannot be made, or another user could have put files there.
    """
    folder = throw_away_folder(router_port)
    _require_private(folder.parent)
    shutil.rmtree(folder, ignore_errors=True)
    Deployment.create(folder, authority_days=THROW_AWAY_DAYS).issue(identities_of([robot]), days=THROW_AWAY_DAYS)
    shutil.rmtree(folder / "authority")  # nobody can issue further certificates of this run
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def discard_throw_away_keys(router_port: int) -> None:
    """Delete keys that a run which was killed has left: a run without keys would be asked for with them."""
    shutil.rmtree(throw_away_folder(router_port), ignore_errors=True)


def _private_folder() -> Path:
    return Path(tempfile.gettempdir()) / f"passafe-{os.getuid()}"


def _require_private(folder: Path) -> None:
    """Make a folder, or check that it is a real one of this user, with access for nobody else."""
    try:
        folder.mkdir(mode=FOLDER_MODE, exist_ok=True)
        status = folder.lstat()
    except OSError as error:
        raise KeysUnreadableError(folder, f"cannot be made: {error.strerror}") from error
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid() or status.st_mode & 0o077:
        raise KeysUnreadableError(
            folder,
            f"got a folder of user {status.st_uid} with mode {status.st_mode & 0o777:04o}, allowed one of yours, 0700",
        )
