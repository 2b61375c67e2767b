"""One pass over a log: its messages in order, as tables or one by one, with memory that does not grow with its length.

Numbers come as columns, thousands of messages at a time::

    run = LogPass(path)
    for part in run.slices({"state": ("plant_ns", "x")}):
        for block in part.blocks("state"):
            block.numbers("plant_ns"), block.matrix("x", 4), block.sequence

Several consumers share one pass, each with columns of its own::

    run.feed(first, second)

Messages come one by one as records::

    for header, body in LogPass(path).messages(FilterTick, PlantState): ...

Order: messages of one session of a publisher come in order of sequence, each once. Topics and sessions come side by
side, about as they were logged: a slice holds a few seconds of all of them, but where a message is missing, what
follows it is held back (``session_order.WINDOW``). So whoever joins topics keeps what has no counterpart yet.
"""

import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, Protocol

from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Metadata
from passafe_protocol.keys import KEY_ROOT
from passafe_protocol.messages import Message as Body
from passafe_protocol.topics import TOPIC_OF_BODY, TOPICS

from passafe_services.log.chunk_decoding import Decode, DecodedStretch, Stretch, Wants, decode_stretch
from passafe_services.log.continuity import LoggedMessage, TopicCount
from passafe_services.log.decoding_workers import DecodingWorkers
from passafe_services.log.errors import ForeignLogError, LogReadError
from passafe_services.log.key_check import key_shortcomings
from passafe_services.log.log_reader import LogReader, definitions
from passafe_services.log.log_writer import RECOVERED_RECORD, SCENARIO_RECORD, topic_of_key
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_columns import RECORD
from passafe_services.log.reading_state import ReadingState
from passafe_services.log.record_scan import Damage, scan_records
from passafe_services.log.session_order import SessionOrder

STRETCH_BYTES: Final = 8 << 20
"""Uncompressed size of what is decoded at a time."""

WORKERS_PAY_BYTES: Final = 24 << 20
"""Size of a log from which on it pays to start processes for it."""

Progress = Callable[[int, int], None]
"""Takes the bytes of the log that have been read, and their total."""


@dataclass(frozen=True, eq=False)
class LogSlice:
    """Messages of all topics that came into order since the slice before."""

    of_topic: Mapping[str, Sequence[MessageBlock]]

    def blocks(self, topic: str) -> Sequence[MessageBlock]:
        """Return the messages of a topic, by its name."""
        return self.of_topic.get(topic, ())


class LogConsumer(Protocol):
    """Whoever takes part in a pass."""

    @property
    def wants(self) -> Wants:
        """Paths of the columns that it reads, by name of the topic; see ``message_field.fields_of``."""
        ...

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        ...


class LogPass:
    """One pass over a log; the attributes are final when it has ended.

    Args:
        path: The log: its first file, or a folder that holds one recording.
        progress: Is called after every stretch.
        workers: Processes to decode with; by default one a processor for a log that is worth it, and none for others.

    Attributes:
        path: The file.
        metadata: Metadata records by name; those before the first message are there from the beginning.
        finished: Whether its writer finished it, also before a recovery, and all of it is intact.
        tear: Description of the damage; empty if ``finished``.
        shortcomings: Reasons for which checkpoints do not prove that nothing is missing, in words.
        counts: Message counts of every topic, by its name.
        foreign_keys: Channels that do not belong to passafe.
        progress: Is called after every stretch.
        size_bytes: Size of the log.

    Raises:
        LogReadError: The file is missing, unreadable, empty or no MCAP file.
    """

    def __init__(self, path: Path, *, progress: Progress | None = None, workers: int | None = None) -> None:
        self.path = path
        self._files = [(file, file.stat().st_size) for file in LogReader(path).files]  # refuses what is no log
        self.finished = False
        self.tear = ""
        self.foreign_keys: list[str] = []
        self.counts: dict[str, TopicCount] = {topic.name: TopicCount() for topic in TOPICS}
        self.progress = progress
        self.size_bytes = sum(size_bytes for _, size_bytes in self._files)
        self._workers = _worth(self.size_bytes) if workers is None else workers
        self._channels: dict[int, str] = {}
        self._undecodable: dict[str, int] = {}
        self._state = ReadingState(self._files)
        self.shortcomings: list[str] = []
        self.metadata: dict[str, dict[str, str]] = {}
        for record, _ in self._records():
            if isinstance(record, Chunk | Message):
                break

    def feed(self, *consumers: LogConsumer) -> None:
        """Read the log once for several consumers.

        Raises:
            ForeignLogError: The log has no channel of passafe.
            LogReadError: The file cannot be read.
        """
        wants: dict[str, set[str]] = {}
        for consumer in consumers:
            for name, paths in consumer.wants.items():
                wants.setdefault(name, set()).update(paths)
        for part in self.slices(wants):
            for consumer in consumers:
                consumer.take(part)

    def messages(self, *bodies: type[Body]) -> Iterator[LoggedMessage[Any]]:
        """Yield every message with one of these bodies: each session in order, topics and sessions side by side."""
        names = [TOPIC_OF_BODY[body].name for body in bodies]
        for part in self.slices(dict.fromkeys(names, (RECORD,))):
            for name in names:
                for block in part.blocks(name):
                    yield from (LoggedMessage(*message) for message in block.objects(RECORD))

    def slices(self, wants: Mapping[str, Collection[str]], *, wanted_only: bool = False) -> Iterator[LogSlice]:
        """Yield the log in slices.

        Args:
            wants: Paths of the wanted columns, by name of the topic; sources, epochs, sequence numbers and wall times
                of all topics come besides.
            wanted_only: Whether topics that ``wants`` does not name are passed over, and not counted either.

        Raises:
            ForeignLogError: The log has no channel of passafe.
            LogReadError: The file cannot be read.
        """
        self._channels, self._undecodable, self.foreign_keys = {}, {}, []
        orders = {topic.name: SessionOrder(topic) for topic in TOPICS}
        for found in self._decoded(partial(decode_stretch, wants=wants, wanted_only=wanted_only)):
            for name, number in found.undecodable.items():
                self._undecodable[name] = self._undecodable.get(name, 0) + number
            yield LogSlice({name: [*orders[name].take(table)] for name, table in found.tables.items()})
        if not self._is_of_passafe(orders, wanted_only=wanted_only):
            keys = ", ".join(self.foreign_keys[:3]) or "none"
            raise ForeignLogError(self.path, f"is no log of passafe: got channels {keys}, allowed {KEY_ROOT}/…")
        yield LogSlice({name: [*order.finish()] for name, order in orders.items()})
        sources = {name: order.sources for name, order in orders.items()}
        self.shortcomings = [*self.shortcomings, *key_shortcomings(self._channels.values(), sources)]
        self.counts = {name: order.count(self._undecodable.get(name, 0)) for name, order in orders.items()}

    def _is_of_passafe(self, orders: Mapping[str, SessionOrder], *, wanted_only: bool) -> bool:
        found = any(order.has_messages for order in orders.values())
        if wanted_only:  # it may have messages that were passed over
            found = found or any(topic_of_key(key) is not None for key in self._channels.values())
        return bool(found or self._undecodable or SCENARIO_RECORD in self.metadata)

    def _decoded(self, decode: Decode) -> Iterator[DecodedStretch]:
        """Yield the decoded stretches in the order of the file."""
        for stretch, found in self._first_decoded(decode):
            for each in found.damage:
                self._note_damage(each)
            known = self._register(found.channels)
            repeated = found
            if not known or found.unknown & self._channels.keys():
                # It was decoded before the channels of the stretches before were known.
                repeated = decode(stretch, self._channels)
            if self.progress is not None:
                self.progress(repeated.read_bytes, self.size_bytes)
            yield repeated
        self.finished = self._state.finished and RECOVERED_RECORD not in self.metadata
        self.tear = self._state.tear or self.metadata.get(RECOVERED_RECORD, {}).get("tear", "")
        self.shortcomings = self._state.audit.shortcomings

    def _first_decoded(self, decode: Decode) -> Iterator[tuple[Stretch, DecodedStretch]]:
        stretches = self._stretches()
        if not self._workers:
            for stretch in stretches:
                yield stretch, decode(stretch, self._channels)
            return
        with DecodingWorkers(self._workers, decode) as workers:
            sent: list[Stretch] = []
            for stretch in stretches:
                if len(sent) < workers.count:
                    workers.send(stretch, self._channels)
                    sent.append(stretch)
                    continue
                found = workers.receive()
                workers.send(stretch, self._channels)
                sent.append(stretch)
                yield sent.pop(0), found
            while sent:
                yield sent.pop(0), workers.receive()

    def _register(self, channels: Mapping[int, str]) -> bool:
        """Register channels; return whether those that were known before are the same."""
        known = all(self._channels.get(number, key) == key for number, key in channels.items())
        for number, key in channels.items():
            if number not in self._channels:
                self._channels[number] = key
                if topic_of_key(key) is None:
                    self.foreign_keys.append(key)
        return known

    def _stretches(self) -> Iterator[Stretch]:
        records: list[Chunk | Channel | Message] = []
        read: list[int] = []
        size_bytes = 0
        for record, read_bytes in self._records():
            if isinstance(record, Chunk | Channel | Message):
                records.append(record)
                read.append(read_bytes)
                size_bytes += record.uncompressed_size if isinstance(record, Chunk) else _size_of(record)
            if size_bytes >= STRETCH_BYTES:
                yield Stretch(records, read)
                records, read, size_bytes = [], [], 0
        if records:
            yield Stretch(records, read)

    def _records(self) -> Iterator[tuple[McapRecord, int]]:
        """Yield every intact record of the files, chunks as they are, with the bytes read up to its end."""
        state = self._state = ReadingState(self._files)
        for number, (file, size_bytes) in enumerate(self._files):
            try:
                with file.open("rb") as stream:
                    for found in scan_records(stream, size_bytes, unpack=False):
                        if isinstance(found, Damage):
                            self._note_damage(found, number)
                            continue
                        for record in found.records:
                            if isinstance(record, DataEnd):
                                state.note_end(number)
                            elif isinstance(record, Metadata):
                                self.metadata[record.name] = record.metadata
                                state.note_metadata(record.name, record.metadata)
                            yield record, state.bases[number] + found.end
            except OSError as error:
                raise LogReadError(file, f"cannot be read: {error.strerror or error}") from error

    def _note_damage(self, damage: Damage, number: int = 0) -> None:
        """Remember damage; after the first of it, what it may have said of channels is taken from elsewhere."""
        if not self._state.damage:
            for file, _ in self._files:
                channels = (each for each in definitions(file) if isinstance(each, Channel))
                self._register({channel.id: channel.topic for channel in channels})
        self._state.note_damage(damage, number)


def _size_of(record: Channel | Message) -> int:
    return len(record.data) if isinstance(record, Message) else 0


def _worth(size_bytes: int) -> int:
    """Return how many processes it pays to start for a log."""
    return len(os.sched_getaffinity(0)) if size_bytes >= WORKERS_PAY_BYTES else 0
