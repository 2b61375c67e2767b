"""Find logs and experiments in the runs folder, by names that cannot lead out of it."""

import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Final

from passafe_dashboard.errors import ArchiveNameError

DEEPEST: Final = 4
"""Folders below the runs folder that are looked into, one in the other: logs of an experiment are two deep."""

MOST_VISITED: Final = 50_000
"""Entries of folders that one look takes in."""

LONGEST_NAME: Final = 1024
LOG_SUFFIX: Final = ".mcap"
EXPERIMENT_SUFFIX: Final = ".toml"
RESULTS: Final = "results.jsonl"
"""File by which the folder of an experiment is known."""


class RunsFolder:
    """The runs folder; a name in it is a relative path with slashes, without hidden parts and without ``..``.

    Args:
        root: The folder; it need not exist yet.
    """

    def __init__(self, root: Path) -> None:
        self.root = root.absolute()

    def logs(self) -> list[str]:
        """Return the names of all logs that can be opened by name, in no order."""
        return [name for name in self._files() if name.endswith(LOG_SUFFIX)]

    def experiments(self) -> list[str]:
        """Return the names of all folders that hold results of a sweep, in no order."""
        parents = (PurePosixPath(name).parent for name in self._files() if PurePosixPath(name).name == RESULTS)
        return [str(parent) for parent in parents if parent.name]

    def toml_files(self) -> list[str]:
        """Return the names of all files that may hold an experiment, in no order."""
        return [name for name in self._files() if name.endswith(EXPERIMENT_SUFFIX)]

    def log(self, name: str) -> Path:
        """Return the path of a log.

        Raises:
            ArchiveNameError: There is no such log in the folder.
        """
        return self._file("log", name, LOG_SUFFIX)

    def experiment(self, name: str) -> Path:
        """Return the path of an experiment's folder.

        Raises:
            ArchiveNameError: There is no such folder with results.
        """
        found = self._inside(f"{name}/{RESULTS}")
        if found is None or not found.is_file():
            raise ArchiveNameError("experiment", name, f"the name of a folder with {RESULTS} in {self.root}")
        return found.parent

    def experiment_file(self, name: str) -> Path:
        """Return the path of a file that may hold an experiment.

        Raises:
            ArchiveNameError: There is no such file in the folder.
        """
        return self._file("experiment", name, EXPERIMENT_SUFFIX)

    def _file(self, kind: str, name: str, suffix: str) -> Path:
        found = self._inside(name) if name.endswith(suffix) else None
        if found is None or not found.is_file():
            raise ArchiveNameError(kind, name, f"the name of a file in {self.root} that ends in {suffix}")
        return found

    def name_of(self, path: Path) -> str:
        """Return the name of a path inside the folder."""
        return path.absolute().relative_to(self.root).as_posix()

    def _inside(self, name: str) -> Path | None:
        """Return the path that a name stands for; ``None`` if it leads anywhere else, by a symbolic link too."""
        if not 0 < len(name) <= LONGEST_NAME or "\0" in name or name.startswith("/"):
            return None
        parts = name.split("/")
        if any(not part or part.startswith(".") for part in parts):
            return None
        path = self.root.joinpath(*parts)
        try:
            inside = path.resolve(strict=True).is_relative_to(self.root.resolve(strict=True))
        except (OSError, RuntimeError, ValueError):  # missing, a loop of links, or text that no path can hold
            return None
        return path if inside else None

    def _files(self) -> Iterator[str]:
        """Yield the names of files; links to folders are not followed."""
        waiting: list[tuple[str, int]] = [("", 0)]
        visited = 0
        while waiting:
            prefix, depth = waiting.pop()
            try:
                entries = list(os.scandir(self.root / prefix))
            except OSError:  # removed meanwhile, or not for this user
                continue
            for entry in entries:
                visited += 1
                if visited > MOST_VISITED:
                    return
                if entry.name.startswith(".") or not _is_text(entry.name):
                    continue
                name = f"{prefix}{entry.name}"
                if entry.is_dir(follow_symlinks=False):
                    if depth < DEEPEST:
                        waiting.append((f"{name}/", depth + 1))
                elif entry.name.endswith((LOG_SUFFIX, RESULTS, EXPERIMENT_SUFFIX)) and self._is_file(entry, name):
                    yield name

    def _is_file(self, entry: os.DirEntry[str], name: str) -> bool:
        if not entry.is_symlink():
            return entry.is_file(follow_symlinks=False)
        path = self._inside(name)
        return path is not None and path.is_file()


def _is_text(name: str) -> bool:
    """Return whether a file's name can stand in JSON and in an address."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True
