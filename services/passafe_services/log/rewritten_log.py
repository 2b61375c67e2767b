"""Compares a log that was written anew with its checkpoints: by message, wherever checkpoints and messages are now.

Other tools sort messages by time and put metadata at the beginning or the end. What was changed can still be named.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np
from mcap.records import Channel, Message, Metadata
from numpy.typing import NDArray

from passafe_services.log.checkpoint import CHECKPOINT_RECORD, Checkpoint, checkpoint_of
from passafe_services.log.interval_diff import ChangedMessage
from passafe_services.log.log_reader import LogReader
from passafe_services.log.manifest import TAG_BYTES, entries_of, key_prefix, message_digest

MOST_COMPARED: Final = 100_000
"""Differing messages that are looked at; beyond them a log is another one."""
_Tags: TypeAlias = NDArray[np.uint64]


class _Named(NamedTuple):
    """Message by its names, with the first bytes of its digest."""

    key: str
    sequence: int
    wall_ns: int
    tag: bytes


def changes_of_rewritten(reader: LogReader, valid: Iterable[int]) -> list[ChangedMessage] | None:
    """Return the messages that were changed, left out or added, whatever the order; ``None`` if too many were.

    Args:
        reader: Reader of the log.
        valid: Numbers of the checkpoints that are signed.
    """
    counted = frozenset(valid)
    attested = _tags(each.tag for each in _attested(reader, counted))
    found = _tags(each.tag for each in _messages(reader))
    missing, surplus = _without(attested, found), _without(found, attested)
    if sum(missing.values()) + sum(surplus.values()) > MOST_COMPARED:
        return None
    changes: list[ChangedMessage] = []
    added: defaultdict[tuple[str, int], list[_Named]] = defaultdict(list)
    for each in _taken(_messages(reader), surplus):
        added[each.key, each.sequence].append(each)
    for each in _taken(_attested(reader, counted), missing):
        others = added[each.key, each.sequence]
        changes.append(ChangedMessage("changed" if others else "left out", each.key, each.sequence, each.wall_ns))
        if others:
            others.pop()
    for others in added.values():
        changes += [ChangedMessage("added", each.key, each.sequence, each.wall_ns) for each in others]
    return changes


def _attested(reader: LogReader, counted: frozenset[int]) -> Iterator[_Named]:
    """Yield the messages of the manifests."""
    for record in reader.records():
        if isinstance(record, Metadata) and record.name == CHECKPOINT_RECORD:
            checkpoint = checkpoint_of(record.metadata)
            if checkpoint is not None and checkpoint.number in counted:
                yield from _entries(checkpoint)


def _entries(checkpoint: Checkpoint) -> Iterator[_Named]:
    try:
        entries = entries_of(checkpoint.manifest, checkpoint.messages)
    except ValueError:
        return
    for each in entries:
        yield _Named(checkpoint.channels.get(each.channel, ""), each.sequence, each.wall_ns, each.tag)


def _messages(reader: LogReader) -> Iterator[_Named]:
    """Yield the messages of the log."""
    keys: dict[int, str] = {}
    prefixes: dict[int, bytes] = {}
    for record in reader.records():
        match record:
            case Channel() if record.id not in keys:
                keys[record.id], prefixes[record.id] = record.topic, key_prefix(record.topic)
            case Message(channel_id=number):
                prefix = prefixes.get(number, b"")
                digest = message_digest(prefix, record.sequence, record.log_time, record.publish_time, record.data)
                yield _Named(keys.get(number, ""), record.sequence, record.log_time, digest[:TAG_BYTES])
            case _:
                pass


def _tags(tags: Iterable[bytes]) -> _Tags:
    """Return tags as integers."""
    joined = bytearray()
    for tag in tags:
        joined += tag
    columns: NDArray[Any] = np.frombuffer(joined, dtype=np.uint8).reshape(-1, TAG_BYTES)
    padded = np.zeros((columns.shape[0], 8), dtype=np.uint8)
    padded[:, :TAG_BYTES] = columns
    return padded.view("<u8").reshape(-1).astype(np.uint64)


def _without(tags: _Tags, others: _Tags) -> dict[bytes, int]:
    """Return the tags that are more often in the first than in the second, and how much more often."""
    values, counts = np.unique(tags, return_counts=True)
    other_values, other_counts = np.unique(others, return_counts=True)
    places = np.searchsorted(other_values, values)
    known = np.zeros(values.shape, dtype=np.int64)
    inside = places < other_values.size
    same = inside.copy()
    same[inside] = other_values[places[inside]] == values[inside]
    known[same] = other_counts[places[same]]
    more = counts - known
    kept = more > 0
    return {
        int(value).to_bytes(8, "little")[:TAG_BYTES]: int(count)
        for value, count in zip(values[kept], more[kept], strict=True)
    }


def _taken(named: Iterable[_Named], wanted: Mapping[bytes, int]) -> Iterator[_Named]:
    """Yield the messages with these tags, each as often as it is wanted."""
    left = dict(wanted)
    for each in named:
        if left.get(each.tag):
            left[each.tag] -= 1
            yield each
