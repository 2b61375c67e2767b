"""Files that a command writes, each of which must be another one than those that it reads."""

import os
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path

from passafe_services.cli.errors import OptionError


def require_separate(outputs: Mapping[str, Path | None], inputs: Iterable[Path]) -> None:
    """Refuse a file that would be written over one that is read, or over another one that is written.

    Nor may it take the place of what is no file: whoever may make devices would replace ``/dev/null`` by a report.

    Args:
        outputs: Files to write, by the options that name them; ``None`` where none does.
        inputs: Files that are read.

    Raises:
        OptionError: One of them is.
    """
    known = {_identity(path): f"{path}, which is read" for path in inputs}
    for option, path in outputs.items():
        if path is None:
            continue
        _require_file(option, path)
        if (other := known.get(_identity(path))) is not None:
            raise OptionError(option, str(path), f"another file than {other}")
        known[_identity(path)] = f"that of {option}"


def _require_file(option: str, path: Path) -> None:
    """Refuse a path at which something else than a file is, or at which no file can be."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    except OSError as error:
        raise OptionError(option, f"{path}: {error.strerror or error}", "a file") from error
    if not stat.S_ISREG(mode):
        raise OptionError(option, f"{path}, a {'folder' if stat.S_ISDIR(mode) else 'device or pipe'}", "a file")


def _identity(path: Path) -> object:
    """Return what two paths of one file have in common, links included."""
    try:
        found = path.stat()
    except OSError:
        return os.path.realpath(path)  # unlike Path.resolve it takes links that lead nowhere
    return found.st_dev, found.st_ino
