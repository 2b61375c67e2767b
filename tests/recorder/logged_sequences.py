"""Sequence numbers of the messages of a log."""

from pathlib import Path

from passafe_services.log.log_reader import LogReader


def sequences(path: Path) -> list[int]:
    return [record.sequence for record in LogReader(path).records() if hasattr(record, "sequence")]
