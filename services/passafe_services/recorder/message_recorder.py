"""Logs each message of the topic table unchanged and counts missing ones."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from passafe_protocol.codec import MAX_MESSAGE_BYTES
from passafe_protocol.keys import parts_of
from passafe_protocol.messages import Header, Receipt, RecordedSession, TopicHealth
from passafe_protocol.sequence import SequenceGuard
from passafe_protocol.sequence_window import USUAL, MissingRange, WindowSize
from passafe_protocol.session_guards import SessionGuards, guard_of
from passafe_protocol.topics import TOPIC_OF_NAME, Topic

from passafe_services.log.wire_header import read_header

OTHERS: Final = "other"
"""Name under which ``health`` counts messages that are not logged."""

_NAME_LENGTH: Final = 80


@dataclass
class _Channel:
    """One key expression: its topic, its publisher and the counts of its messages."""

    topic: Topic
    source: str
    guard: SequenceGuard | SessionGuards
    invalid: int = 0


class MessageSink(Protocol):
    """Takes messages to log, such as ``BackgroundLog`` and ``LogWriter``."""

    def write(self, key: str, data: bytes, *, sequence: int, wall_ns: int) -> None:
        """Log one message."""
        ...


class MessageRecorder:
    """Writes messages from the bus to a log.

    Every message under a key of the topic table is logged, also invalid and duplicate ones: the log shows what was on
    the wire. Only the counts distinguish them. Messages under other keys, and those larger than any message can be, are
    counted and not logged: whoever may publish on the bus cannot make the log's table of channels grow, which has room
    for 65,535.

    Args:
        log: Log to write to.
        size: How much of a session is remembered and believed.

    Attributes:
        bytes_recorded: Wire bytes logged so far.
        others: Messages that were not logged.
        last_other: Description of the last of these; empty without one.
    """

    def __init__(self, log: MessageSink, size: WindowSize = USUAL) -> None:
        self.bytes_recorded = 0
        self.others = 0
        self.last_other = ""
        self._log = log
        self._size = size
        self._channels: dict[str, _Channel] = {}

    def record(self, samples: Iterable[tuple[str, bytes]], wall_ns: int, now_ns: int) -> None:
        """Log messages from the bus.

        Args:
            samples: Key expression and wire bytes of each message, in order of arrival.
            wall_ns: Wall time now, ns: log time of messages without a valid header.
            now_ns: Monotonic time now, ns; non-decreasing.

        Raises:
            LogWriteError: The log cannot be written.
        """
        for key, data in samples:
            channel = self._channels.get(key) or self._open(key)
            if channel is None and _is_left_out(key):
                continue
            if channel is None or len(data) > MAX_MESSAGE_BYTES:
                self.others += 1
                self.last_other = f"{len(data)} bytes under {key[:_NAME_LENGTH]}"
                continue
            header = self._count(channel, data, now_ns)
            if header is None:
                self._log.write(key, data, sequence=0, wall_ns=wall_ns)
            else:
                self._log.write(key, data, sequence=header.sequence, wall_ns=header.wall_ns)
            self.bytes_recorded += len(data)

    def gaps(self) -> dict[str, int]:
        """Return the number of messages missing so far, by key expression; keys without gaps are omitted."""
        return {key: channel.guard.gaps for key, channel in self._channels.items() if channel.guard.gaps}

    def missing(self) -> dict[str, list[MissingRange]]:
        """Return what publishers may still have, by key expression: numbers missing in their current sessions."""
        found = {key: channel.guard.missing() for key, channel in self._channels.items() if channel.guard.gaps}
        return {key: ranges for key, ranges in found.items() if ranges}

    def record_missed(self, samples: Sequence[tuple[str, bytes]], wall_ns: int, now_ns: int) -> None:
        """Log those messages from the publishers' caches that are still missing.

        Args:
            samples: Key expression and wire bytes of each message.
            wall_ns: Wall time now, ns.
            now_ns: Monotonic time now, ns.

        Raises:
            LogWriteError: The log cannot be written.
        """
        missing = self.missing()
        wanted: list[tuple[str, bytes]] = []
        taken: set[tuple[str, int, int]] = set()
        for key, data in samples:
            header = read_header(self._channels[key].topic, data) if key in missing else None
            if header is None or (one := (key, header.epoch, header.sequence)) in taken:
                continue
            if any(each.epoch == header.epoch and each.first <= header.sequence <= each.last for each in missing[key]):
                taken.add(one)
                wanted.append((key, data))
        self.record(wanted, wall_ns, now_ns)

    def health(self) -> tuple[TopicHealth, ...]:
        """Return the counts of each topic over all its publishers, sorted by name; those not logged at the end."""
        totals: defaultdict[str, list[int]] = defaultdict(lambda: [0, 0, 0])
        for channel in self._channels.values():
            total = totals[channel.topic.name]
            total[0] += channel.guard.received
            total[1] += channel.guard.gaps
            total[2] += channel.guard.refused + channel.invalid
        rows = [
            TopicHealth(topic=name, received=received, gaps=gaps, refused=refused)
            for name, (received, gaps, refused) in sorted(totals.items())
        ]
        return (*rows, TopicHealth(OTHERS, 0, 0, self.others)) if self.others else tuple(rows)

    def receipt(self, expects: Callable[[str, MissingRange], bool]) -> Receipt:
        """Return how far each session that is remembered is recorded: up to the first message that is waited for.

        Args:
            expects: Tells whether missing messages under a key may still come.
        """
        missing = self.missing()
        sessions: list[RecordedSession] = []
        for key, channel in self._channels.items():
            waited_for = [each for each in missing.get(key, ()) if expects(key, each)]
            for session in channel.guard.sessions:
                first = min((each.first for each in waited_for if each.epoch == session.epoch), default=None)
                newest = session.newest if first is None else first - 1
                sessions.append(RecordedSession(channel.source, channel.topic.name, session.epoch, newest))
        return Receipt(tuple(sessions))

    def _open(self, key: str) -> _Channel | None:
        """Return a new channel; ``None`` for a key that is not of the table."""
        found = _row_of(key)
        if found is None or not found[0].recorded:
            return None
        self._channels[key] = channel = _Channel(*found, guard_of(found[0], self._size))
        return channel

    def _count(self, channel: _Channel, data: bytes, now_ns: int) -> Header | None:
        """Count a message and return its header; ``None`` if that is missing or invalid."""
        header = read_header(channel.topic, data)
        if header is None or header.source != channel.source or header.wall_ns < 0:
            channel.invalid += 1
            return None
        channel.guard.classify(header, now_ns)
        return header


def _row_of(key: str) -> tuple[Topic, str] | None:
    """Return topic and publisher of a key; ``None`` if it is not of the topic table."""
    parts = parts_of(key)
    topic = None if parts is None else TOPIC_OF_NAME.get(parts.topic)
    return None if parts is None or topic is None or parts.source not in topic.publishers else (topic, parts.source)


def _is_left_out(key: str) -> bool:
    """Return whether the topic table says that messages under this key are not recorded."""
    found = _row_of(key)
    return found is not None and not found[0].recorded
