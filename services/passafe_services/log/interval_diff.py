"""Compares the messages between two checkpoints with their manifest: which was changed, left out, added or moved?"""

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, TypeAlias

from passafe_services.log.manifest import Entry

Change: TypeAlias = Literal["changed", "left out", "added", "moved"]


class ChangedMessage(NamedTuple):
    """Message that is not as it was logged.

    Attributes:
        change: What was done to it.
        key: Key expression under which it was published.
        sequence: Its sequence number; of a changed one as it was.
        wall_ns: Its log time, ns; of a changed one as it was.
    """

    change: Change
    key: str
    sequence: int
    wall_ns: int


def changed_messages(
    attested: Sequence[Entry], found: Sequence[Entry], channels: Mapping[int, str]
) -> list[ChangedMessage]:
    """Return what differs between two lists of messages, in the order of the attested ones, additions last.

    Args:
        attested: Messages of the manifest.
        found: Messages of the file, with the channel numbers of the manifest.
        channels: Key expression of every channel, by its number.
    """
    surplus = Counter(found) - Counter(attested)
    replaced: defaultdict[tuple[int, int], list[Entry]] = defaultdict(list)
    for entry in surplus.elements():
        replaced[entry.channel, entry.sequence].append(entry)
    missing = Counter(attested) - Counter(found)
    changes: list[ChangedMessage] = []

    def note(change: Change, entry: Entry) -> None:
        key = channels.get(entry.channel, f"channel {entry.channel}")
        changes.append(ChangedMessage(change, key, entry.sequence, entry.wall_ns))

    for entry in attested:
        if missing[entry]:
            missing[entry] -= 1
            others = replaced[entry.channel, entry.sequence]
            note("changed" if others else "left out", entry)
            if others:
                others.pop()
    for entry in _moved(attested, found):
        note("moved", entry)
    for others in replaced.values():
        for entry in others:
            note("added", entry)
    return changes


def _moved(attested: Sequence[Entry], found: Sequence[Entry]) -> list[Entry]:
    """Return messages in both lists that are in another order: of two that were swapped both, else as few as can be."""
    places: defaultdict[Entry, list[int]] = defaultdict(list)
    kept = list((Counter(attested) & Counter(found)).elements())
    wanted = Counter(kept)
    order: list[Entry] = []
    for entry in attested:
        if wanted[entry]:
            wanted[entry] -= 1
            places[entry].append(len(order))
            order.append(entry)
    ranks = [places[entry].pop(0) for entry in found if places[entry]]
    wrong = [rank for place, rank in enumerate(ranks) if place != rank]
    if len(wrong) > 2:  # noqa: PLR2004 - two are a swap
        wrong = sorted(set(ranks) - _longest_increasing(ranks))
    return [order[rank] for rank in sorted(wrong)]


def _longest_increasing(ranks: Sequence[int]) -> set[int]:
    """Return the values of a longest increasing subsequence."""
    tails: list[int] = []
    before: dict[int, int | None] = {}
    for rank in ranks:
        at = bisect_left(tails, rank)
        before[rank] = tails[at - 1] if at else None
        tails[at : at + 1] = [rank]
    found: set[int] = set()
    rank_or_none = tails[-1] if tails else None
    while rank_or_none is not None:
        found.add(rank_or_none)
        rank_or_none = before[rank_or_none]
    return found
