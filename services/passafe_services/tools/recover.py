"""Recovers a complete log from a truncated or damaged one."""

import json
from dataclasses import dataclass
from pathlib import Path

from passafe_services.log.errors import LogReadError
from passafe_services.log.log_file import LogFile, in_place_of
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import RECOVERED_RECORD
from passafe_services.log.record_scan import Damage
from passafe_services.tools.recovered_copy import Loss, RecoveredCopy


@dataclass(frozen=True, kw_only=True)
class Recovery:
    """Result of a recovery.

    Attributes:
        messages: Number of messages kept.
        duration_s: Log time from the first message to the last, s.
        channels: Messages kept, by topic of the channel.
        was_finished: Whether the file was already complete.
        tear: Description of the damage; empty if the file was complete.
        losses: What is lost, place by place.
        orphans: Intact messages that are left out, since no intact record says of which channel they are.
        altered: Names of the metadata records that are missing or not as they were written.
    """

    messages: int
    duration_s: float
    channels: dict[str, int]
    was_finished: bool
    tear: str
    losses: tuple[Loss, ...]
    orphans: int
    altered: tuple[str, ...]


def recover(torn: Path, out: Path) -> Recovery:
    """Copy everything intact in ``torn``, before and after damage, into a complete file ``out``.

    ``torn`` is not changed. ``out`` appears when it is complete: an interrupted recovery leaves none.

    Args:
        torn: A log whose writer was killed, or that is damaged; a complete one is copied too.
        out: The file to write; must not exist.

    Returns:
        Result of the recovery.

    Raises:
        LogReadError: ``torn`` is missing, empty or no MCAP file, or nothing that was logged is intact in it.
        LogWriteError: ``out`` exists or cannot be written.
    """
    reader = LogReader(torn, alone=True)
    with in_place_of(out) as fresh, LogFile(fresh) as file:
        copy = RecoveredCopy(file)
        with file.guarded():
            for item in reader.items():
                if isinstance(item, Damage):
                    copy.skip(item)
                else:
                    copy.add(item)
            if copy.is_empty and not reader.finished:
                raise LogReadError(torn, _nothing(reader.tear, copy.orphans))
            if not reader.finished:
                losses = json.dumps([loss.as_json() for loss in copy.losses])
                note = {"tear": reader.tear, "messages": str(copy.messages), "losses": losses}
                file.mcap.add_metadata(RECOVERED_RECORD, note)
    return Recovery(
        messages=copy.messages,
        duration_s=copy.duration_s,
        channels=copy.counts,
        was_finished=reader.finished,
        tear=reader.tear,
        losses=tuple(copy.losses),
        orphans=copy.orphans,
        altered=tuple(sorted(copy.altered)),
    )


def _nothing(tear: str, orphans: int) -> str:
    """Return why a log cannot be recovered at all, in words."""
    said = f", and {orphans} messages of which no intact record says what they are" if orphans else ""
    return f"nothing to recover: {tear}{said}; needs one message, attachment or metadata record that is intact"
