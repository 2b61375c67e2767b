"""Log of a run in memory: decoded messages, counts of missing ones, and the identity of the run."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Self, TypeVar, cast

from mcap.records import Channel, Metadata
from mcap.records import Message as Record
from passafe_protocol import codec
from passafe_protocol.errors import ProtocolError
from passafe_protocol.keys import KEY_ROOT
from passafe_protocol.messages import Message, ScenarioInfo
from passafe_protocol.topics import SCENARIO, TOPIC_OF_BODY, TOPIC_OF_NAME, TOPICS, Topic

from passafe_services.log.chunk_decoding import ORDER_FIELDS, Wants
from passafe_services.log.continuity import LoggedMessage, TopicCount, in_order
from passafe_services.log.errors import ForeignLogError
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import RECOVERED_RECORD, SCENARIO_RECORD, topic_of_key
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_columns import columns_of
from passafe_services.tools.review.run_identity import RunIdentity, identify

B = TypeVar("B", bound=Message)


@dataclass
class _Contents:
    """Contents of the file in the order of its records."""

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: dict[str, list[LoggedMessage[Message]]] = field(default_factory=dict)  # by the topic's name
    undecodable: dict[str, int] = field(default_factory=dict)
    foreign_keys: list[str] = field(default_factory=list)

    @property
    def is_of_passafe(self) -> bool:
        return bool(self.messages or self.undecodable or SCENARIO_RECORD in self.metadata)


@dataclass(frozen=True, kw_only=True)
class RunLog:
    """Log of one run.

    Attributes:
        path: The file.
        finished: Whether its writer finished it, also before a recovery.
        tear: Description of the damage at which reading stopped; empty if the end was reached.
        identity: Scenario, driver and versions of the run.
        counts: Message counts of every topic, by its name.
        foreign_keys: Channels that do not belong to passafe.
        shortcomings: Reasons for which its checkpoints do not prove that nothing is missing, in words.
        messages: Messages by name of the topic; see ``of``.
    """

    path: Path
    finished: bool
    tear: str
    identity: RunIdentity
    counts: Mapping[str, TopicCount]
    foreign_keys: tuple[str, ...]
    shortcomings: tuple[str, ...]
    messages: Mapping[str, list[LoggedMessage[Message]]] = field(repr=False)

    def of(self, body: type[B]) -> list[LoggedMessage[B]]:
        """Return every message with this body, by source and session, each in order of sequence."""
        topic = TOPIC_OF_BODY[cast("type[Message]", body)]
        # The codec decodes every message of a topic into the body type of that topic.
        return cast("list[LoggedMessage[B]]", self.messages.get(topic.name, []))

    def slices(self, wants: Wants) -> Iterator[LogSlice]:
        """Yield the log as a pass over its file does, in one slice; see ``LogPass.slices``."""
        blocks: dict[str, list[MessageBlock]] = {}
        for name, messages in self.messages.items():
            paths = {*ORDER_FIELDS, *wants.get(name, ())}
            sessions = groupby(messages, key=lambda message: (message.header.source, message.header.epoch))
            for number, ((source, epoch), session) in enumerate(sessions):
                columns = columns_of(TOPIC_OF_NAME[name], list(session), paths)
                blocks.setdefault(name, []).append(MessageBlock(TOPIC_OF_NAME[name], source, epoch, number, columns))
        yield LogSlice(blocks)

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a log; of a damaged one, everything intact.

        Args:
            path: Its first file, or a folder that holds one recording.

        Raises:
            LogReadError: The file is missing, empty or no MCAP file.
            ForeignLogError: It has no channel of passafe.
            ScenarioRecordError: It does not say which scenario it is of, or this build cannot read that.
        """
        reader = LogReader(path)
        contents = _contents(reader)
        if not contents.is_of_passafe:
            found = ", ".join(contents.foreign_keys[:3]) or "none"
            raise ForeignLogError(path, f"is no log of passafe: got channels {found}, allowed {KEY_ROOT}/…")
        counts = {topic.name: TopicCount() for topic in TOPICS}
        for name, number in contents.undecodable.items():
            counts[name].undecodable = number
        messages = {name: in_order(found, counts[name]) for name, found in contents.messages.items()}
        info = next((message.body for message in messages.get(SCENARIO.name, ())), None)
        return cls(
            path=path,
            finished=reader.finished and RECOVERED_RECORD not in contents.metadata,
            tear=reader.tear or contents.metadata.get(RECOVERED_RECORD, {}).get("tear", ""),
            identity=identify(path, contents.metadata, info if isinstance(info, ScenarioInfo) else None),
            counts=counts,
            foreign_keys=tuple(contents.foreign_keys),
            shortcomings=tuple(reader.shortcomings),
            messages=messages,
        )


def _contents(reader: LogReader) -> _Contents:
    contents = _Contents()
    topics: dict[int, Topic | None] = {}
    for record in reader.records():
        match record:
            case Record():
                topic = topics.get(record.channel_id)
                if topic is not None:
                    _decode(topic, record.data, contents)
            case Channel() if record.id not in topics:
                topics[record.id] = topic = topic_of_key(record.topic)
                if topic is None:
                    contents.foreign_keys.append(record.topic)
            case Metadata():
                contents.metadata[record.name] = record.metadata
            case _:
                pass  # schemas are known to the codec; indexes and statistics are not needed
    return contents


def _decode(topic: Topic, data: bytes, contents: _Contents) -> None:
    try:
        header, body = codec.decode(topic, data)
    except ProtocolError:
        contents.undecodable[topic.name] = contents.undecodable.get(topic.name, 0) + 1
    else:
        contents.messages.setdefault(topic.name, []).append(LoggedMessage(header, body))
