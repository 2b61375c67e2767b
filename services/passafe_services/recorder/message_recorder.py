"""Logs each message unchanged and counts missing ones."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

from passafe_protocol.keys import parts_of
from passafe_protocol.messages import Header, TopicHealth
from passafe_protocol.sequence import SequenceGuard
from passafe_protocol.topics import Topic

from passafe_services.log.log_writer import LogWriter, topic_of_key
from passafe_services.log.wire_header import read_header


@dataclass
class _Channel:
    """One key expression: its topic, its publisher and the counts of its messages."""

    topic: Topic | None
    source: str
    guard: SequenceGuard = field(default_factory=SequenceGuard)
    invalid: int = 0


class MessageRecorder:
    """Writes messages from the bus to a log.

    Every message is logged, also invalid and duplicate ones: the log shows what was on the wire. Only the counts
    distinguish them.

    Args:
        log: Log to write to.

    Attributes:
        bytes_recorded: Wire bytes logged so far.
    """

    def __init__(self, log: LogWriter) -> None:
        self.bytes_recorded = 0
        self._log = log
        self._channels: dict[str, _Channel] = {}

    def record(self, samples: Iterable[tuple[str, bytes]], wall_ns: int) -> None:
        """Log messages from the bus.

        Args:
            samples: Key expression and wire bytes of each message, in order of arrival.
            wall_ns: Wall time now, ns: log time of messages without a valid header.

        Raises:
            LogWriteError: The log cannot be written.
        """
        for key, data in samples:
            channel = self._channels.get(key) or self._open(key)
            header = self._count(channel, data)
            if header is None:
                self._log.write(key, data, sequence=0, wall_ns=wall_ns)
            else:
                self._log.write(key, data, sequence=header.sequence, wall_ns=header.wall_ns)
            self.bytes_recorded += len(data)

    def gaps(self) -> dict[str, int]:
        """Return the number of messages missing so far, by key expression; keys without gaps are omitted."""
        return {key: channel.guard.gaps for key, channel in self._channels.items() if channel.guard.gaps}

    def health(self) -> tuple[TopicHealth, ...]:
        """Return the message counts of each topic over all its publishers, sorted by name."""
        totals: defaultdict[str, list[int]] = defaultdict(lambda: [0, 0, 0])
        for key, channel in self._channels.items():
            total = totals[channel.topic.name if channel.topic else key]
            total[0] += channel.guard.received
            total[1] += channel.guard.gaps
            total[2] += channel.guard.refused + channel.invalid
        return tuple(
            TopicHealth(topic=name, received=received, gaps=gaps, refused=refused)
            for name, (received, gaps, refused) in sorted(totals.items())
        )

    def _open(self, key: str) -> _Channel:
        parts = parts_of(key)
        channel = _Channel(topic=topic_of_key(key), source=parts.source if parts else "")
        self._channels[key] = channel
        return channel

    def _count(self, channel: _Channel, data: bytes) -> Header | None:
        """Count a message and return its header; ``None`` if that is missing or invalid."""
        header = read_header(channel.topic, data) if channel.topic else None
        if header is None or header.source != channel.source or header.wall_ns < 0:
            channel.invalid += 1
            return None
        channel.guard.classify(header)
        return header
