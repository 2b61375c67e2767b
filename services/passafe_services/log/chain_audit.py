"""Follows the checkpoints of a log: does it have all of them, and what do they say is missing?"""

from collections.abc import Mapping

from passafe_services.log.checkpoint import Checkpoint, body_digest, checkpoint_of

_SHOWN = 3
"""Key expressions named in one line."""


class ChainAudit:
    """Audit of the checkpoints of a log, in the order of its files.

    It does not check signatures or messages: ``verification`` does.

    Attributes:
        breaks: What is wrong with the chain, in words.
        last: The last checkpoint; ``None`` without one.
    """

    def __init__(self) -> None:
        self.breaks: list[str] = []
        self.last: Checkpoint | None = None
        self._previous = ""
        self._expected = 0

    def take(self, record: Mapping[str, str]) -> Checkpoint | None:
        """Take the metadata record of the next checkpoint; return the checkpoint, or ``None`` if it is damaged."""
        found = checkpoint_of(record)
        if found is None:
            self.breaks.append(f"checkpoint {self._expected} is damaged")
            return None
        if self.last is not None and found.recording != self.last.recording:
            self.breaks.append(f"checkpoint {found.number} is of another recording")
        elif found.number > self._expected:
            self.breaks.append(f"checkpoints {self._expected} to {found.number - 1} are missing")
        elif found.number < self._expected or found.previous != self._previous:
            self.breaks.append(f"checkpoint {found.number} does not continue the one before it")
        self.last, self._expected, self._previous = found, found.number + 1, body_digest(record["body"])
        return found

    @property
    def shortcomings(self) -> list[str]:
        """Reasons for which the log is not proven complete, in words; empty if it is, or if it has no checkpoints."""
        if self.last is None:
            return list(self.breaks)
        said = list(self.breaks)
        if not self.last.final:
            said.append(f"the recording does not end at its last checkpoint, {self.last.number}")
        gaps = {key: count.gaps for key, count in self.last.counts.items() if count.gaps}
        lost = {key: count.lost for key, count in self.last.counts.items() if count.lost}
        if gaps:
            said.append(f"messages that the recorder never received: {_listed(gaps)}")
        if lost:
            said.append(f"messages that the recorder could not write: {_listed(lost)}")
        return said


def _listed(counts: Mapping[str, int]) -> str:
    shown = [f"{count} of {key}" for key, count in sorted(counts.items(), key=lambda each: -each[1])]
    return ", ".join(shown[:_SHOWN]) + (f", and of {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else "")
