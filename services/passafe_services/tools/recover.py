"""Recovers a complete log from a truncated one."""

from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, McapRecord, Message, Metadata, Schema

from passafe_services.log.log_file import LogFile
from passafe_services.log.log_reader import LogReader

RECOVERED_RECORD = "recovered"
"""Metadata record that marks a recovered log."""


@dataclass(frozen=True, kw_only=True)
class Recovery:
    """Result of a recovery.

    Attributes:
        messages: Number of messages kept.
        duration_s: Log time from the first message to the last, s.
        channels: Messages kept, by topic of the channel.
        was_finished: Whether the file was already complete.
        tear: Description of the damage at which reading stopped; empty if the file was complete.
    """

    messages: int
    duration_s: float
    channels: dict[str, int]
    was_finished: bool
    tear: str


class _Copy:
    """Copies records into a new file with unchanged schemas, channels and times."""

    def __init__(self, out: LogFile) -> None:
        self._mcap = out.mcap
        self._schemas = {0: 0}  # 0 is MCAP's "no schema"
        self._channels: dict[int, tuple[int, str]] = {}
        self.counts: dict[str, int] = {}
        self.first_ns: int | None = None
        self.last_ns: int | None = None

    def add(self, record: McapRecord) -> None:
        match record:
            case Schema(id=number) if number not in self._schemas:
                self._schemas[number] = self._mcap.register_schema(record.name, record.encoding, record.data)
            case Channel(id=number) if number not in self._channels and record.schema_id in self._schemas:
                self._channel(record)
            case Message(channel_id=number) if number in self._channels:
                self._message(record)
            case Metadata():
                self._mcap.add_metadata(record.name, record.metadata)
            case _:
                pass  # indexes and statistics are rewritten

    def _channel(self, record: Channel) -> None:
        schema = self._schemas[record.schema_id]
        number = self._mcap.register_channel(record.topic, record.message_encoding, schema, record.metadata)
        self._channels[record.id] = (number, record.topic)
        self.counts.setdefault(record.topic, 0)

    def _message(self, record: Message) -> None:
        channel, topic = self._channels[record.channel_id]
        self._mcap.add_message(channel, record.log_time, record.data, record.publish_time, record.sequence)
        self.counts[topic] += 1
        self.first_ns = record.log_time if self.first_ns is None else min(self.first_ns, record.log_time)
        self.last_ns = record.log_time if self.last_ns is None else max(self.last_ns, record.log_time)


def recover(torn: Path, out: Path) -> Recovery:
    """Copy everything readable in ``torn`` into a complete file ``out``; ``torn`` is not changed.

    Args:
        torn: A log whose writer was killed; a complete one is copied too.
        out: The file to write; must not exist.

    Returns:
        Result of the recovery.

    Raises:
        LogReadError: ``torn`` is missing, empty or no MCAP file.
        LogWriteError: ``out`` exists or cannot be written.
    """
    reader = LogReader(torn)
    with LogFile(out, replace=False) as file:
        copy = _Copy(file)
        with file.guarded():
            for record in reader.records():
                copy.add(record)
            messages = sum(copy.counts.values())
            if not reader.finished:
                file.mcap.add_metadata(RECOVERED_RECORD, {"tear": reader.tear, "messages": str(messages)})
    span_ns = 0 if copy.first_ns is None or copy.last_ns is None else copy.last_ns - copy.first_ns
    return Recovery(
        messages=messages,
        duration_s=span_ns * 1e-9,
        channels=copy.counts,
        was_finished=reader.finished,
        tear=reader.tear,
    )
