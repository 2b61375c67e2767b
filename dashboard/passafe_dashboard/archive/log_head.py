"""Read from the first and last bytes of a log what it is of, without reading the rest."""

import json
from io import BytesIO
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple

from mcap.records import Chunk, Message, Metadata
from mcap.writer import MCAP0_MAGIC
from passafe_services.log.log_writer import DRIVER_RECORD, SCENARIO_RECORD
from passafe_services.log.record_scan import IntactRecord, scan_records

HEAD_BYTES: Final = 128 << 10
"""Bytes at the beginning in which a log says what it is of: a scenario takes a few kB."""

WHAT_IF: Final = "what-if"
"""Metadata record of a log that a what-if wrote."""

LogState = Literal["finished", "unfinished", "no log"]


class LogHead(NamedTuple):
    """Identity of a log, as its first bytes say it.

    Attributes:
        state: ``unfinished``: its end is missing, because it is being recorded or torn.
        scenario: Name of the scenario; empty if it does not say.
        title: Its title.
        mode: Mode of the filter.
        driver: live or lockstep.
        source: Log from which a what-if made it; empty for any other.
        changes: What the what-if changed, in words.
    """

    state: LogState
    scenario: str = ""
    title: str = ""
    mode: str = ""
    driver: str = ""
    source: str = ""
    changes: tuple[str, ...] = ()


def read_head(path: Path) -> LogHead:
    """Return what a log says of itself.

    Raises:
        OSError: It cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
        size = file.seek(0, 2)
        file.seek(max(0, size - len(MCAP0_MAGIC)))
        tail = file.read()
    if not head.startswith(MCAP0_MAGIC):
        return LogHead("no log")
    is_finished = size > 2 * len(MCAP0_MAGIC) and tail == MCAP0_MAGIC
    found = _metadata(head)
    what_if = found.get(WHAT_IF, {})
    scenario = _json(found.get(SCENARIO_RECORD, {}).get("json", ""))
    changes = _json(what_if.get("changes", ""))
    return LogHead(
        state="finished" if is_finished else "unfinished",
        scenario=_text(scenario, "name"),
        title=_text(scenario, "title"),
        mode=_text(scenario.get("filter") if isinstance(scenario, dict) else None, "mode"),
        driver=found.get(DRIVER_RECORD, {}).get("kind", ""),
        source=what_if.get("source", ""),
        changes=tuple(_change(each) for each in changes) if isinstance(changes, list) else (),
    )


def _metadata(head: bytes) -> dict[str, dict[str, str]]:
    """Return the metadata records before the first message."""
    found: dict[str, dict[str, str]] = {}
    for each in scan_records(BytesIO(head), len(head), unpack=False):
        if not isinstance(each, IntactRecord):
            break
        for record in each.records:
            if isinstance(record, Metadata):
                found[record.name] = record.metadata
            elif isinstance(record, Chunk | Message):
                return found
    return found


def _json(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return None


def _text(values: object, key: str) -> str:
    return str(values.get(key, "")) if isinstance(values, dict) else ""


def _change(change: Any) -> str:  # noqa: ANN401 - what a log holds
    if not isinstance(change, dict):
        return str(change)
    return f"{change.get('key')} {change.get('before')} → {change.get('after')}"
