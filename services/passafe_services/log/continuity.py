"""Sorts the messages of one topic and counts missing ones."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from passafe_protocol.messages import Header, Message

B = TypeVar("B", bound=Message)


class LoggedMessage(NamedTuple, Generic[B]):
    """Message of a log."""

    header: Header
    body: B


@dataclass(kw_only=True)
class TopicCount:
    """Message counts of one topic in a log, over all its publishers.

    Attributes:
        received: Distinct messages decoded.
        gaps: Sequence numbers missing between the first and the last of each publisher's session, and before the first
            of a session other than its publisher's first. The last messages of a killed process cannot be counted.
        missed_at_start: Sequence numbers missing before the first of each publisher's first session.
        sessions: Sessions of all publishers; a restarted publisher has several.
        duplicates: Messages that were in the log more than once.
        undecodable: Messages that are not valid for their topic.
        first_gap_wall_ns: Wall time of the message before the first gap, ns.
        out_of_order: Messages that came too late to be put in order, see ``session_order``; they are left out.
        contradicting: Messages with the number of another one, and other content; the first of each counts.
    """

    received: int = 0
    gaps: int = 0
    missed_at_start: int = 0
    duplicates: int = 0
    undecodable: int = 0
    sessions: int = 0
    first_gap_wall_ns: int | None = None
    out_of_order: int = 0
    contradicting: int = 0


def in_order(found: Iterable[LoggedMessage[Message]], count: TopicCount) -> list[LoggedMessage[Message]]:
    """Sort by source, session and sequence, drop duplicates, and add to ``count``.

    Sessions of a source are in the order in which the log met them: epochs identify them and do not order them.
    """
    ordered: list[LoggedMessage[Message]] = []
    last: Header | None = None
    session_number: dict[tuple[str, int], int] = {}

    def place(message: LoggedMessage[Message]) -> tuple[str, int, int]:
        header = message.header
        number = session_number.setdefault((header.source, header.epoch), len(session_number))
        return header.source, number, header.sequence

    for message in sorted(found, key=place):
        header = message.header
        expected = 0
        if last is None or (last.source, last.epoch) != (header.source, header.epoch):
            count.sessions += 1
        elif header.sequence == last.sequence:
            count.duplicates += 1
            count.contradicting += message != ordered[-1]
            continue
        else:
            expected = last.sequence + 1
        if last is None or last.source != header.source:
            count.missed_at_start += header.sequence
        elif header.sequence > expected:
            count.gaps += header.sequence - expected
            if count.first_gap_wall_ns is None or last.wall_ns < count.first_gap_wall_ns:
                count.first_gap_wall_ns = last.wall_ns
        ordered.append(message)
        last = header
    count.received = len(ordered)
    return ordered
