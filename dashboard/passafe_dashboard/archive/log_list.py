"""List the logs in the runs folder, the newest first."""

import re
from pathlib import Path
from time import time
from typing import Final, Literal

from pydantic import BaseModel, ConfigDict

from passafe_dashboard.archive.log_head import LogHead, read_head
from passafe_dashboard.archive.runs_folder import LOG_SUFFIX, RunsFolder
from passafe_dashboard.errors import ArchiveNameError

MOST_LISTED: Final = 500
GROWS_S: Final = 5.0
"""Time since the last write within which a log without an end counts as being recorded, s."""

EntryState = Literal["finished", "recording", "torn", "no log"]

_PART: Final = re.compile(rf"(.*)\.\d+{re.escape(LOG_SUFFIX)}")


class LogEntry(BaseModel):
    """One log of the list.

    Attributes:
        name: Name in the runs folder.
        size_bytes: Size of all its files.
        modified_s: Unix time of its last change, s.
        state: ``torn``: its end is missing, and nobody writes to it. ``no log``: a file that only has the name of one.
        scenario: Name of its scenario; empty if it does not say.
        title: Title of that.
        mode: Mode of the filter.
        driver: live or lockstep.
        source: Log from which a what-if made it; empty for any other.
        changes: What the what-if changed, in words.
        files: Number of files that it consists of.
        verdict: Verdict of its review in the page, in a few words; empty if it was not reviewed as it is now.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    size_bytes: int
    modified_s: float
    state: EntryState
    scenario: str
    title: str
    mode: str
    driver: str
    source: str
    changes: tuple[str, ...]
    files: int
    verdict: str = ""

    @property
    def stamp(self) -> tuple[int, float]:
        """State of its files: another one as soon as they change."""
        return self.size_bytes, self.modified_s


class LogList(BaseModel):
    """Logs in the runs folder.

    Attributes:
        folder: The folder.
        logs: The newest first.
        left_out: Number of older ones that are not listed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    folder: str
    logs: tuple[LogEntry, ...]
    left_out: int


class LogLister:
    """Lists the logs of a folder; what a log says of itself is read once while it does not change.

    Call from a worker thread: it reads files.

    Args:
        folder: The folder.
    """

    def __init__(self, folder: RunsFolder) -> None:
        self._folder = folder
        self._heads: dict[tuple[Path, int, int], LogHead] = {}

    def newest(self) -> LogList:
        """Return the logs, the newest first."""
        names = self._folder.logs()
        parts = _parts(names)
        firsts = [name for name in names if name not in parts]
        newest = sorted(((self._changed_s(name), name) for name in firsts), reverse=True)
        files: dict[str, list[str]] = {}
        for part, first in parts.items():
            files.setdefault(first, []).append(part)
        entries = (self._entry(name, files.get(name, [])) for _, name in newest[:MOST_LISTED])
        logs = tuple(entry for entry in entries if entry is not None)
        return LogList(folder=str(self._folder.root), logs=logs, left_out=max(0, len(newest) - MOST_LISTED))

    def entry(self, name: str) -> LogEntry:
        """Return one log.

        Raises:
            ArchiveNameError: There is no such log in the folder.
        """
        path = self._folder.log(name)
        beside = [self._folder.name_of(each) for each in path.parent.glob(f"*{LOG_SUFFIX}")]
        parts = [part for part, first in _parts(beside).items() if first == name]
        found = self._entry(name, parts)
        if found is None:
            raise ArchiveNameError("log", name, "a log that is still there and may be read")
        return found

    def _changed_s(self, name: str) -> float:
        try:
            return (self._folder.root / name).stat().st_mtime
        except OSError:
            return 0.0

    def _entry(self, name: str, parts: list[str]) -> LogEntry | None:
        path = self._folder.root / name
        try:
            stats = [path.stat(), *((self._folder.root / part).stat() for part in parts)]
            head = self._head(path, stats[0].st_size, stats[0].st_mtime_ns)
            last = head if not parts else self._last(parts)
        except OSError:
            return None
        changed_s = max(stat.st_mtime for stat in stats)
        return LogEntry(
            name=name,
            size_bytes=sum(stat.st_size for stat in stats),
            modified_s=changed_s,
            state=_state(head, last, time() - changed_s),
            scenario=head.scenario,
            title=head.title,
            mode=head.mode,
            driver=head.driver,
            source=head.source,
            changes=head.changes,
            files=len(stats),
        )

    def _last(self, parts: list[str]) -> LogHead:
        path = self._folder.root / max(parts, key=lambda part: (len(part), part))
        stat = path.stat()
        return self._head(path, stat.st_size, stat.st_mtime_ns)

    def _head(self, path: Path, size: int, changed_ns: int) -> LogHead:
        key = (path, size, changed_ns)
        if key not in self._heads:
            if len(self._heads) >= 4 * MOST_LISTED:
                self._heads.clear()
            self._heads[key] = read_head(path)
        return self._heads[key]


def _state(first: LogHead, last: LogHead, unchanged_s: float) -> EntryState:
    """Return the state of a log from its first and its last file."""
    if first.state == "no log":
        return "no log"
    if last.state == "finished":
        return "finished"
    return "recording" if unchanged_s < GROWS_S else "torn"


def _parts(names: list[str]) -> dict[str, str]:
    """Return the later files of recordings among names, each with the first file of its recording."""
    known = set(names)
    found = {}
    for name in names:
        match = _PART.fullmatch(name)
        if match and match[1] + LOG_SUFFIX in known:
            found[name] = match[1] + LOG_SUFFIX
    return found
