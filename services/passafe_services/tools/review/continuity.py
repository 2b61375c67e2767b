"""Puts the messages of one topic in order and counts what is missing among them."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from passafe_protocol.messages import Header, Message

B = TypeVar("B", bound=Message)


class LoggedMessage(NamedTuple, Generic[B]):
    """One message of the log."""

    header: Header
    body: B


@dataclass(kw_only=True)
class TopicCount:
    """How much of one topic the log holds, over all its publishers.

    Attributes:
        received: Messages decoded, each counted once.
        gaps: Sequence numbers missing between the first and the last of each publisher's session, and before the
            first of a session that is not its publisher's first. How many a killed process sent last, nobody knows.
        missed_at_start: Sequence numbers before the first of each publisher's first session.
        sessions: Sessions, over all publishers: one that was started again has two.
        repeated: Messages that were in the log more than once.
        undecodable: Messages that are not valid for their topic.
        first_gap_wall_ns: Wall time of the message before the first gap.
    """

    received: int = 0
    gaps: int = 0
    missed_at_start: int = 0
    repeated: int = 0
    undecodable: int = 0
    sessions: int = 0
    first_gap_wall_ns: int | None = None


def in_order(found: Iterable[LoggedMessage[Message]], count: TopicCount) -> list[LoggedMessage[Message]]:
    """Sort by source, session and sequence, drop repetitions, and count into ``count``."""
    ordered: list[LoggedMessage[Message]] = []
    last: Header | None = None
    for message in sorted(found, key=_session_and_sequence):
        header = message.header
        expected = 0
        if last is None or (last.source, last.epoch) != (header.source, header.epoch):
            count.sessions += 1
        elif header.sequence == last.sequence:
            count.repeated += 1
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


def _session_and_sequence(message: LoggedMessage[Message]) -> tuple[str, int, int]:
    return message.header.source, message.header.epoch, message.header.sequence
