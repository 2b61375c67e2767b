"""Removes from an installation what a running system never reads: tests, headers, solvers that passafe does not use."""

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

UNREAD: Final = (
    "**/tests",
    "**/*.a",
    "**/*.pyi",
    "**/*.pyx",
    "**/include",
    "casadi/cmake",
)
"""Patterns of files and folders below ``site-packages``."""

KEPT_OF_CASADI: Final = (
    "_casadi",
    "libcasadi.",
    "libcasadi_linsol_",
    "libcasadi_interpolant_",
    "libcasadi_rootfinder_",
)
"""First letters of CasADi's libraries that stay: expressions and their evaluation; the rest are optimizers."""


def trim(installation: Path) -> None:
    """Remove what is not read, and replace copies of a library under several names by links."""
    for packages in installation.glob("lib/python3*/site-packages"):
        unread = [path for pattern in UNREAD for path in packages.glob(pattern)]
        for path in [*unread, *_solvers(packages / "casadi")]:
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)
        for folder in packages.glob("*/"):
            _link_copies(folder)


def _solvers(folder: Path) -> Iterator[Path]:
    return (path for path in folder.glob("*.so*") if not path.name.startswith(KEPT_OF_CASADI))


def _link_copies(folder: Path) -> None:
    """Leave of a library that a wheel holds as ``lib.so``, ``lib.so.1`` and ``lib.so.1.2`` one file and two links."""
    originals: dict[bytes, Path] = {}
    for path in sorted(folder.glob("*.so*"), reverse=True):
        original = originals.setdefault(path.read_bytes(), path)
        if original is not path:
            path.unlink()
            path.symlink_to(original.name)


if __name__ == "__main__":
    trim(Path(sys.argv[1]))
