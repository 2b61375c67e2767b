"""Copies the intact records of a damaged log, and notes what is missing between them."""

from dataclasses import dataclass, field
from typing import Any, TypeAlias

from mcap.records import Attachment, Channel, McapRecord, Message, Metadata, Schema
from mcap.well_known import SchemaEncoding
from passafe_protocol.codec import file_descriptor_set, schema_name

from passafe_services.log.checkpoint import CHECKPOINT_RECORD, checkpoint_of, record_digest
from passafe_services.log.log_file import LogFile
from passafe_services.log.log_writer import topic_of_key
from passafe_services.log.record_scan import Damage

Missing: TypeAlias = dict[str, tuple[int, int]]


@dataclass(kw_only=True)
class Loss:
    """Place of a log at which something is lost.

    Attributes:
        damage: Its bytes, and what is wrong with them.
        after_ns: Log time of the last message before it, ns; ``None`` if there is none.
        before_ns: Log time of the first message after it, ns; ``None`` if there is none.
        missing: Sequence numbers of the first and last message missing there, by topic of the channel; only of
            channels with messages before and after it.
    """

    damage: Damage
    after_ns: int | None = None
    before_ns: int | None = None
    missing: Missing = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Return the loss as an object for JSON; numbers are as in the attributes."""
        return {
            "start_byte": self.damage.start,
            "end_byte": self.damage.end,
            "reason": self.damage.reason,
            "first_ns": self.damage.first_ns,
            "last_ns": self.damage.last_ns,
            "after_ns": self.after_ns,
            "before_ns": self.before_ns,
            "missing": self.missing,
        }


class RecoveredCopy:
    """Copies records into a new file with unchanged schemas, channels, times and attachments.

    Args:
        out: The new file; call everything inside its ``guarded()``.

    Attributes:
        counts: Messages copied, by topic of the channel.
        losses: Damage that was skipped.
        orphans: Messages of a channel that no record describes; they are left out.
        altered: Names of the metadata records that are missing or not as they were written.
        is_empty: Whether nothing was copied that somebody logged: no message, no attachment, no metadata.
    """

    def __init__(self, out: LogFile) -> None:
        self.is_empty = True
        self.counts: dict[str, int] = {}
        self.losses: list[Loss] = []
        self.orphans = 0
        self.altered: set[str] = set()
        self._metadata: dict[str, str] = {}
        self._mcap = out.mcap
        self._schemas = {0: 0}  # 0 is MCAP's "no schema"
        self._channels: dict[int, tuple[int, str]] = {}
        self._sequences: dict[int, int] = {}
        self._before_damage: dict[int, int] = {}
        self._first_ns: int | None = None
        self._last_ns: int | None = None
        self._newest_ns: int | None = None

    @property
    def messages(self) -> int:
        """Messages copied."""
        return sum(self.counts.values())

    @property
    def duration_s(self) -> float:
        """Log time from the first message to the last, s."""
        return 0.0 if self._first_ns is None or self._last_ns is None else (self._last_ns - self._first_ns) * 1e-9

    def add(self, record: McapRecord) -> None:
        """Copy a record; indexes and statistics are written anew."""
        match record:
            case Schema(id=number) if number not in self._schemas:
                self._schemas[number] = self._mcap.register_schema(record.name, record.encoding, record.data)
            case Channel(id=number) if number not in self._channels:
                self._add_channel(record)
            case Message(channel_id=number) if number in self._channels:
                self._add_message(record)
            case Message():
                self.orphans += 1
            case Metadata():
                self.is_empty = False
                self._add_metadata(record)
            case Attachment():
                self.is_empty = False
                times = record.create_time, record.log_time
                self._mcap.add_attachment(*times, record.name, record.media_type, record.data)
            case _:
                pass

    def _add_metadata(self, record: Metadata) -> None:
        """Copy a metadata record after the messages before it, which it may attest."""
        self._mcap.flush()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
        self._mcap.add_metadata(record.name, record.metadata)
        if record.name != CHECKPOINT_RECORD:
            self._metadata[record.name] = record_digest(record.metadata)
            return
        checkpoint = checkpoint_of(record.metadata)
        if checkpoint is None:
            self.altered.add(record.name)
            return
        for name, digest in checkpoint.metadata.items():
            if self._metadata.get(name) != digest:
                self.altered.add(name)

    def skip(self, damage: Damage) -> None:
        """Note damage at this place."""
        self.losses.append(Loss(damage=damage, after_ns=self._newest_ns))
        self._before_damage |= self._sequences
        self._sequences.clear()

    def _add_channel(self, record: Channel) -> None:
        schema = self._schemas.get(record.schema_id)
        if schema is None:  # lost: of our own topics it is known, of others their messages are kept without one
            schema = self._schemas[record.schema_id] = self._known_schema(record.topic)
        number = self._mcap.register_channel(record.topic, record.message_encoding, schema, record.metadata)
        self._channels[record.id] = (number, record.topic)
        self.counts.setdefault(record.topic, 0)

    def _known_schema(self, key: str) -> int:
        topic = topic_of_key(key)
        if topic is None:
            return 0
        name, data = schema_name(topic), file_descriptor_set()
        number: int = self._mcap.register_schema(name, SchemaEncoding.Protobuf, data)
        return number

    def _add_message(self, record: Message) -> None:
        channel, topic = self._channels[record.channel_id]
        self._mcap.add_message(channel, record.log_time, record.data, record.publish_time, record.sequence)
        self.counts[topic] += 1
        self.is_empty = False
        self._first_ns = record.log_time if self._first_ns is None else min(self._first_ns, record.log_time)
        self._last_ns = record.log_time if self._last_ns is None else max(self._last_ns, record.log_time)
        self._newest_ns = record.log_time
        self._sequences[record.channel_id] = record.sequence
        if self.losses:
            self._note_after_damage(record, topic)

    def _note_after_damage(self, record: Message, topic: str) -> None:
        """Note the first message of a channel after damage: what is missing of it since the one before."""
        loss = self.losses[-1]
        if loss.before_ns is None:
            loss.before_ns = record.log_time
        before = self._before_damage.pop(record.channel_id, None)
        if before is not None and record.sequence > before + 1:
            loss.missing[topic] = (before + 1, record.sequence - 1)
