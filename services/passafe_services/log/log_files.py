"""Files of a recording: the first is named by its user, the others are numbered beside it."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from mcap.records import Message, Metadata

from passafe_services.log.checkpoint import CHECKPOINT_RECORD, checkpoint_of
from passafe_services.log.errors import LogReadError
from passafe_services.log.record_scan import Damage, scan_records

RECORDING_RECORD = "recording"
"""Metadata record with the ``id`` of the recording and the number of the file in it, ``part``."""

_TORN = ".torn"
"""Ending of the stem of a file in whose place a recovered one was put."""


class _Place(NamedTuple):
    """Place of a file: the recording that it is of, and its number in that."""

    recording: str
    part: int


def part_path(first: Path, part: int) -> Path:
    """Return the path of a file of a recording: ``run.mcap``, ``run.2.mcap``, ``run.3.mcap`` and so on.

    Args:
        first: Path of the first file.
        part: Number of the file, from 1.
    """
    return first if part == 1 else first.with_name(f"{first.stem}.{part}{first.suffix}")


def files_of(path: Path) -> list[Path]:
    """Return the files of a recording in order.

    Args:
        path: The first file, or a folder that holds one recording. Any other file stands for itself.

    Raises:
        LogReadError: The folder holds no recording, or several.
    """
    if path.is_dir():
        return _in_folder(path)
    place = _place_of(path)
    if place is None or place.part != 1:
        return [path]
    numbered = re.compile(rf"{re.escape(path.stem)}\.\d+{re.escape(path.suffix)}")
    try:
        beside = [other for other in path.parent.iterdir() if numbered.fullmatch(other.name)]
    except OSError:  # a folder that may be entered and not listed
        beside = []
    others = [(each, _place_of(each)) for each in beside]
    return [path, *_sorted((each, found) for each, found in others if found and found.recording == place.recording)]


def _in_folder(folder: Path) -> list[Path]:
    try:
        logs = sorted(each for each in folder.glob("*.mcap") if not each.stem.endswith(_TORN))
    except OSError as error:
        raise LogReadError(folder, f"cannot be read: {error.strerror or error}") from error
    found: dict[str, list[tuple[Path, _Place]]] = {}
    for log in logs:
        place = _place_of(log) or _Place(log.name, 1)
        found.setdefault(place.recording, []).append((log, place))
    if len(found) != 1:
        firsts = ", ".join(_sorted(each)[0].name for each in list(found.values())[:3])
        got = f"got {len(found)} recordings ({firsts})" if found else "got no recording"
        raise LogReadError(folder, f"{got}, allowed one: name its first file")
    return _sorted(next(iter(found.values())))


def _sorted(found: Iterable[tuple[Path, _Place]]) -> list[Path]:
    return [path for path, _ in sorted(found, key=lambda each: each[1].part)]


def _place_of(path: Path) -> _Place | None:
    """Return the place of a file; ``None`` if it does not say so, or cannot be read."""
    if not path.is_file():  # to open a pipe waits for its writer
        return None
    try:
        with path.open("rb") as stream:
            for found in scan_records(stream, path.stat().st_size, unpack=False):
                for record in () if isinstance(found, Damage) else found.records:
                    if isinstance(record, Metadata) and (place := _place_in(record)):
                        return place
                    if isinstance(record, Message):
                        return None
    except OSError:
        return None
    return None


def _place_in(record: Metadata) -> _Place | None:
    if record.name == RECORDING_RECORD:
        number = record.metadata.get("part", "")
        return _Place(record.metadata.get("id", ""), int(number)) if number.isdecimal() else None
    checkpoint = checkpoint_of(record.metadata) if record.name == CHECKPOINT_RECORD else None
    return None if checkpoint is None else _Place(checkpoint.recording, checkpoint.part)
