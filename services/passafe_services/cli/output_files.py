"""Files that a command writes, each of which must be another one than those that it reads."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from passafe_services.cli.errors import OptionError


def require_separate(outputs: Mapping[str, Path | None], inputs: Iterable[Path]) -> None:
    """Refuse a file that would be written over one that is read, or over another one that is written.

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
        if (other := known.get(_identity(path))) is not None:
            raise OptionError(option, str(path), f"another file than {other}")
        known[_identity(path)] = f"that of {option}"


def _identity(path: Path) -> object:
    """Return what two paths of one file have in common, links included."""
    try:
        found = path.stat()
    except OSError:
        return path.resolve()
    return found.st_dev, found.st_ino
