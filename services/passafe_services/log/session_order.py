"""Puts the messages of one topic in order, session by session, while a log is read; with bounded memory.

A message that is missing is waited for while the window lasts, and is a gap after that. One that comes later still is
counted as out of order and left out, so that whoever reads in one pass never sees a session go back.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.topics import Topic

from passafe_services.log.column import Column, Places, joined, take
from passafe_services.log.continuity import TopicCount
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_columns import CHECKSUM

KEPT: Final = 1 << 17
"""Messages of a session whose checksums are kept for copies that come later."""

WINDOW: Final = 1 << 16
"""Messages of a session that may come before a message that precedes them: a minute at 1 kHz."""

Table = dict[str, Column]


@dataclass(kw_only=True, eq=False)
class _Session:
    """One session of a publisher.

    Attributes:
        source: The publisher.
        epoch: Its session.
        number: Number of the session on its topic, in the order in which the log met them.
        expected: Next sequence number.
        first: First sequence number; ``None`` before it.
        last_wall_ns: Wall time of the last message.
        gaps: Ranges of sequence numbers that were given up, the end excluded.
        missing: Messages missing between others.
        first_gap_wall_ns: Wall time of the message before the first gap.
        waiting: Tables of messages after a gap, in order.
        given: Numbers and checksums of messages that were given out, the newest ones.
    """

    source: str
    epoch: int
    number: int
    expected: int = 0
    first: int | None = None
    last_wall_ns: int = 0
    gaps: list[tuple[int, int]] = field(default_factory=list)
    missing: int = 0
    first_gap_wall_ns: int | None = None
    waiting: list[Table] = field(default_factory=list)
    given: tuple[NDArray[Any], NDArray[Any]] = (np.zeros(0, dtype=np.uint64), np.zeros(0, dtype=np.uint32))


class SessionOrder:
    """Messages of one topic in order.

    Args:
        topic: The topic.
    """

    def __init__(self, topic: Topic) -> None:
        self.topic = topic
        self._window = WINDOW
        self._sessions: dict[tuple[str, int], _Session] = {}
        self._received = self._duplicates = self._out_of_order = self._contradicting = 0

    @property
    def has_messages(self) -> bool:
        """True if any came."""
        return bool(self._sessions)

    @property
    def sources(self) -> set[str]:
        """Processes that sent any."""
        return {source for source, _ in self._sessions}

    def take(self, table: Table) -> Iterator[MessageBlock]:
        """Take messages as they are in the log, and yield those that are in order now."""
        for session, rows in self._of_sessions(table):
            yield from self._ordered(session, rows)

    def finish(self) -> Iterator[MessageBlock]:
        """Yield what still waits for messages that are not in the log."""
        for session in self._sessions.values():
            waiting, session.waiting = session.waiting, []
            for table in waiting:
                yield self._block(session, table)

    def count(self, undecodable: int) -> TopicCount:
        """Return the counts of the topic, final after ``finish``."""
        count = TopicCount(
            received=self._received,
            duplicates=self._duplicates,
            undecodable=undecodable,
            out_of_order=self._out_of_order,
            contradicting=self._contradicting,
            sessions=len(self._sessions),
        )
        before: _Session | None = None
        walls: list[int] = []
        for session in sorted(self._sessions.values(), key=lambda one: (one.source, one.number)):
            first = session.first or 0
            if before is None or before.source != session.source:
                count.missed_at_start += first
            elif first:
                count.gaps += first
                walls.append(before.last_wall_ns)
            count.gaps += session.missing
            if session.first_gap_wall_ns is not None:
                walls.append(session.first_gap_wall_ns)
            before = session
        count.first_gap_wall_ns = min(walls, default=None)
        return count

    def _of_sessions(self, table: Table) -> list[tuple[_Session, Table]]:
        """Return the messages of each session in a table."""
        sources: Any = table["header.source"]
        codes, epochs = sources.codes, _integers(table, "header.epoch")
        if (codes == codes[0]).all() and (epochs == epochs[0]).all():
            return [(self._session(sources.words[codes[0]], int(epochs[0])), table)]
        found: dict[tuple[str, int], list[int]] = {}
        for row, key in enumerate(zip((sources.words[code] for code in codes.tolist()), epochs.tolist(), strict=True)):
            found.setdefault(key, []).append(row)
        return [
            (self._session(*key), {path: take(column, np.array(rows)) for path, column in table.items()})
            for key, rows in found.items()
        ]

    def _session(self, source: str, epoch: int) -> _Session:
        key = (source, epoch)
        if key not in self._sessions:
            self._sessions[key] = _Session(source=source, epoch=epoch, number=len(self._sessions))
        return self._sessions[key]

    def _ordered(self, session: _Session, table: Table) -> Iterator[MessageBlock]:
        sequence = _sequence(table)
        if not (np.diff(sequence) == 1).all() or session.waiting or int(sequence[0]) != session.expected:
            table = self._merged(session, table)
            sequence = _sequence(table)
        if not sequence.size:
            return
        if int(sequence[0]) == session.expected and not session.waiting:
            in_turn = _in_turn(sequence)
            yield self._block(session, _rows(table, np.arange(in_turn)))
            table = _rows(table, np.arange(in_turn, sequence.size))
        if _sequence(table).size:
            session.waiting.append(table)
        while sum(len(_sequence(one)) for one in session.waiting) > self._window:
            yield from self._give_up(session)

    def _merged(self, session: _Session, table: Table) -> Table:
        """Return messages in order and once, with those that waited if they belong among them."""
        sequence = _sequence(table)
        late = sequence < np.uint64(session.expected)
        if late.any():
            given_up = sum(_is_in(number, session.gaps) for number in sequence[late].tolist())
            self._out_of_order += given_up
            self._duplicates += int(late.sum()) - given_up
            self._contradicting += _differing(session.given, sequence[late], _integers(table, CHECKSUM)[late])
            table = _rows(table, np.nonzero(~late)[0])
            sequence = _sequence(table)
        if not sequence.size:
            return table
        if session.waiting and int(sequence.min()) <= int(_sequence(session.waiting[-1])[-1]):
            table = {path: joined([*(one[path] for one in session.waiting), column]) for path, column in table.items()}
            session.waiting = []
            sequence = _sequence(table)
        order = np.argsort(sequence, kind="stable")
        first = np.diff(sequence[order], prepend=sequence[order[:1]] + np.uint64(1)) != 0
        self._duplicates += int((~first).sum())
        checksums = _integers(table, CHECKSUM)[order]
        self._contradicting += int((~first[1:] & (np.diff(checksums.astype(np.int64)) != 0)).sum())
        return _rows(table, order[first])

    def _give_up(self, session: _Session) -> Iterator[MessageBlock]:
        """Yield the oldest messages that wait, and stop to wait for what is missing before and among them."""
        table = session.waiting.pop(0)
        half = self._window // 2
        if len(_sequence(table)) > half and not session.waiting:
            kept = np.arange(len(_sequence(table)) - half, len(_sequence(table)))
            session.waiting.append(_rows(table, kept))
            table = _rows(table, np.arange(kept[0]))
        yield self._block(session, table)
        if session.waiting and int(_sequence(session.waiting[0])[0]) == session.expected:
            table = session.waiting.pop(0)
            in_turn = _in_turn(_sequence(table))
            yield self._block(session, _rows(table, np.arange(in_turn)))
            if in_turn < len(_sequence(table)):
                session.waiting.insert(0, _rows(table, np.arange(in_turn, len(_sequence(table)))))

    def _block(self, session: _Session, table: Table) -> MessageBlock:
        """Return messages that are in order, and account for what is missing before and among them."""
        sequence = _sequence(table)
        walls = _integers(table, "header.wall_ns")
        if session.first is None:
            session.first = int(sequence[0])
            if session.first:
                session.gaps.append((0, session.first))
        elif int(sequence[0]) > session.expected:
            self._gap(session, session.expected, int(sequence[0]), session.last_wall_ns)
        for row in np.nonzero(np.diff(sequence) != 1)[0].tolist():
            self._gap(session, int(sequence[row]) + 1, int(sequence[row + 1]), int(walls[row]))
        session.expected = int(sequence[-1]) + 1
        session.last_wall_ns = int(walls[-1])
        self._received += sequence.size
        numbers, checksums = session.given
        session.given = (
            np.concatenate((numbers, sequence))[-KEPT:],
            np.concatenate((checksums, _integers(table, CHECKSUM)))[-KEPT:],
        )
        return MessageBlock(self.topic, session.source, session.epoch, session.number, table)

    @staticmethod
    def _gap(session: _Session, begin: int, end: int, wall_ns: int) -> None:
        session.gaps.append((begin, end))
        session.missing += end - begin
        if session.first_gap_wall_ns is None or wall_ns < session.first_gap_wall_ns:
            session.first_gap_wall_ns = wall_ns


def _differing(given: tuple[NDArray[Any], NDArray[Any]], numbers: NDArray[Any], checksums: NDArray[Any]) -> int:
    """Return how many messages differ from those of the same number that were given out."""
    known, before = given
    if not known.size:
        return 0
    place = np.minimum(np.searchsorted(known, numbers), known.size - 1)
    return int(((known[place] == numbers) & (before[place] != checksums)).sum())


def _sequence(table: Table) -> NDArray[np.uint64]:
    return _integers(table, "header.sequence")


def _integers(table: Table, path: str) -> NDArray[Any]:
    column = table[path]
    if not isinstance(column, np.ndarray):
        raise TypeError(f"{path}: got {type(column).__name__}, allowed numbers")
    return column


def _rows(table: Table, rows: Places) -> Table:
    if rows.size == len(_sequence(table)) and (np.diff(rows) == 1).all():
        return table
    return {path: take(column, rows) for path, column in table.items()}


def _in_turn(sequence: NDArray[np.uint64]) -> int:
    """Return how many numbers follow one another from the first on."""
    (breaks,) = np.nonzero(np.diff(sequence) != 1)
    return int(breaks[0]) + 1 if breaks.size else sequence.size


def _is_in(number: int, ranges: Sequence[tuple[int, int]]) -> bool:
    return any(begin <= number < end for begin, end in ranges)
