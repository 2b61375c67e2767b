"""State of a reading of the files of a log: where they are damaged, whether they are finished, what is missing."""

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from pathlib import Path

from passafe_services.log.chain_audit import ChainAudit
from passafe_services.log.checkpoint import CHECKPOINT_RECORD
from passafe_services.log.record_scan import Damage, described


class ReadingState:
    """State of a reading; offsets count from the beginning of the first file over all of them.

    Args:
        files: Path and size of every file.

    Attributes:
        damage: What is not intact so far.
        audit: Audit of the checkpoints.
    """

    def __init__(self, files: Sequence[tuple[Path, int]]) -> None:
        self.damage: list[Damage] = []
        self.audit = ChainAudit()
        self._files = files
        self.bases = [0, *accumulate(size for _, size in files)]
        self._ended: set[int] = set()

    def note_metadata(self, name: str, record: Mapping[str, str]) -> None:
        """Note a metadata record."""
        if name == CHECKPOINT_RECORD:
            self.audit.take(record)

    def note_end(self, number: int) -> None:
        """Note that the writer finished a file, by its number from 0."""
        self._ended.add(number)

    def note_damage(self, damage: Damage, number: int = 0) -> None:
        """Note damage, whose offsets are those in a file, by its number from 0."""
        base = self.bases[number]
        self.damage.append(replace(damage, start=damage.start + base, end=damage.end + base))

    @property
    def finished(self) -> bool:
        """True if the writer finished the log, and all of it is intact.

        A file that is continued by the next one need not have an end of its own: the checkpoints show that nothing is
        missing between them.
        """
        last = len(self._files) - 1
        continued = self.audit.last is not None and not self.audit.breaks
        return not self.damage and last in self._ended and (continued or len(self._ended) == len(self._files))

    @property
    def tear(self) -> str:
        """Description of the damage; empty if ``finished``."""
        if self.finished:
            return ""
        said = []
        for number, (path, size) in enumerate(self._files):
            text = described(self._damage_of(number), size, ended=number in self._ended)
            if text:
                said.append(text if len(self._files) == 1 else f"{path.name}: {text}")
        return "; ".join(said)

    def _damage_of(self, number: int) -> list[Damage]:
        """Return the damage of a file in order, with offsets in the file."""
        base = self.bases[number]
        found = [each for each in self.damage if bisect_right(self.bases, each.start) - 1 == number]
        moved = [replace(each, start=each.start - base, end=each.end - base) for each in found]
        return sorted(moved, key=lambda each: each.start)
