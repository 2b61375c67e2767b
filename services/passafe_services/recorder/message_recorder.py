"""What the recorder does with each message: log it as it is, and count what is missing."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

from passafe_protocol.messages import Header, TopicHealth
from passafe_protocol.sequence import SequenceGuard
from passafe_protocol.topics import Topic

from passafe_services.log.log_writer import LogWriter, topic_of_key
from passafe_services.log.wire_header import read_header


@dataclass
class _Channel:
    """One key expression: its topic, its publisher and what came of it."""

    topic: Topic | None
    source: str
    guard: SequenceGuard = field(default_factory=SequenceGuard)
    bad: int = 0


class MessageRecorder:
    """A log being filled from the bus.

    Every message is logged, also one that is no valid message, repeated or foreign: the log shows what was
    on the wire. Only the count tells them apart.

    Args:
        log: Where messages go.

    Attributes:
        bytes_taken: Wire bytes logged so far.
    """

    def __init__(self, log: LogWriter) -> None:
        self.bytes_taken = 0
        self._log = log
        self._channels: dict[str, _Channel] = {}

    def take(self, samples: Iterable[tuple[str, bytes]], wall_ns: int) -> None:
        """Log what came off the bus.

        Args:
            samples: Key expression and wire bytes of each message, in order of arrival.
            wall_ns: Wall time now: the time in the log of a message that does not tell its own.

        Raises:
            LogWriteError: The disk does not take it.
        """
        for key, data in samples:
            channel = self._channels.get(key) or self._open(key)
            header = self._judged(channel, data)
            if header is None:
                self._log.write(key, data, sequence=0, wall_ns=wall_ns)
            else:
                self._log.write(key, data, sequence=header.sequence, wall_ns=header.wall_ns)
            self.bytes_taken += len(data)

    def gaps(self) -> dict[str, int]:
        """Messages missing between others so far, by key expression; keys without gaps are left out."""
        return {key: channel.guard.gaps for key, channel in self._channels.items() if channel.guard.gaps}

    def health(self) -> tuple[TopicHealth, ...]:
        """What came of each topic so far, over all its publishers, by the topic's name."""
        totals: defaultdict[str, list[int]] = defaultdict(lambda: [0, 0, 0])
        for key, channel in self._channels.items():
            total = totals[channel.topic.name if channel.topic else key]
            total[0] += channel.guard.received
            total[1] += channel.guard.gaps
            total[2] += channel.guard.refused + channel.bad
        return tuple(
            TopicHealth(topic=name, received=received, gaps=gaps, refused=refused)
            for name, (received, gaps, refused) in sorted(totals.items())
        )

    def _open(self, key: str) -> _Channel:
        topic = topic_of_key(key)
        channel = _Channel(topic=topic, source=key.split("/")[1] if topic else "")
        self._channels[key] = channel
        return channel

    def _judged(self, channel: _Channel, data: bytes) -> Header | None:
        """The message's header, counted; ``None`` if it has none that can be believed."""
        header = read_header(channel.topic, data) if channel.topic else None
        if header is None or header.source != channel.source or header.wall_ns < 0:
            channel.bad += 1
            return None
        channel.guard.classify(header)
        return header
