"""Output that appears under its name only once it is whole."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from passafe_services.tools.export.errors import ExportError

UNFINISHED: Final = ".unfinished"
"""Behind the name of output that is still written."""


@contextmanager
def whole_output(path: Path) -> Iterator[Path]:
    """Yield the path to write to; at the end of the block it takes the place of ``path``.

    After an error, or Ctrl-C, what was written is removed and what stood under ``path`` before is still there. A link
    stays: the file that it leads to is replaced.

    Args:
        path: The file or folder; of a folder that there is everything is replaced.

    Raises:
        ExportError: It cannot be written.
    """
    place = Path(os.path.realpath(path))  # also of ".", which has no name
    unfinished = place.with_name(place.name + UNFINISHED)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        _remove(unfinished)
        yield unfinished
        if place.is_dir() and unfinished.is_dir():
            shutil.rmtree(place)
        unfinished.replace(place)
    except OSError as error:
        raise ExportError(path, error) from error
    finally:
        with suppress(OSError):  # the first error is the one to report
            _remove(unfinished)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
