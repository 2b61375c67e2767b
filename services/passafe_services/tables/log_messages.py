"""Messages of a log, decoded one after the other: what it takes does not grow with the log."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, Metadata
from mcap.records import Message as McapMessage
from passafe_protocol import codec
from passafe_protocol.errors import ProtocolError
from passafe_protocol.keys import KEY_ROOT, parts_of
from passafe_protocol.messages import Header, Message, ScenarioInfo
from passafe_protocol.topics import TOPIC_OF_NAME, Topic
from pydantic import ValidationError

from passafe_services.log.errors import LogReadError
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import SCENARIO_RECORD
from passafe_services.scenarios.schema import Scenario


class LoggedRow(NamedTuple):
    """One message of a log.

    Attributes:
        topic: Its topic.
        key: Key expression under which it was published.
        log_ns: Its log time, Unix time, ns.
        header: Its header.
        body: Its body.
        data: Its wire bytes.
    """

    topic: Topic
    key: str
    log_ns: int
    header: Header
    body: Message
    data: bytes


class LogMessages:
    """Messages of one log, in the order of the file, which may be iterated again.

    Args:
        path: The log.
        topics: Names of the topics that are wanted; all of them if not given.

    Attributes:
        path: The log.
        start_ns: Earliest log time of the messages read, whatever their topic, ns; ``None`` before the first.
        scenario: Scenario of the run, once it was read; ``None`` if the log has none that this build can read.
        tear: After an iteration: description of the damage at which reading stopped; empty if the end was reached.
        shortcomings: After an iteration: reasons for which the log does not show that nothing is missing, in words.
        refused: After an iteration: messages that do not decode, by name of the topic.

    Raises:
        LogReadError: The file is missing, empty or no MCAP file.
    """

    def __init__(self, path: Path, topics: Iterable[str] = TOPIC_OF_NAME) -> None:
        self._reader = LogReader(path)
        self._topics = frozenset(topics)
        self.path = path
        self.start_ns: int | None = None
        self.scenario: Scenario | None = None
        self.tear = ""
        self.shortcomings: tuple[str, ...] = ()
        self.refused: dict[str, int] = {}

    def __iter__(self) -> Iterator[LoggedRow]:
        """Yield every message of passafe that decodes.

        Raises:
            LogReadError: The log has no channel of passafe, or those of several robots.
        """
        self.refused = {}
        channels: dict[int, tuple[Topic, str]] = {}
        robots: set[str] = set()
        for record in self._reader.records():
            if isinstance(record, McapMessage):
                found = channels.get(record.channel_id)
                if found is not None and (row := self._row(record, *found)) is not None:
                    yield row
            elif isinstance(record, Channel):
                self._add(record, channels, robots)
            elif isinstance(record, Metadata) and record.name == SCENARIO_RECORD:
                self.scenario = _scenario(record.metadata.get("json", ""))
        self.tear, self.shortcomings = self._reader.tear, tuple(self._reader.shortcomings)
        if not channels:
            raise LogReadError(self.path, f"is no log of passafe: it has no channel {KEY_ROOT}/…")

    def _add(self, channel: Channel, channels: dict[int, tuple[Topic, str]], robots: set[str]) -> None:
        parts = parts_of(channel.topic)
        topic = None if parts is None else TOPIC_OF_NAME.get(parts.topic)
        if parts is None or topic is None:
            channels.pop(channel.id, None)  # the next file of a log numbers its channels anew
            return
        channels[channel.id] = topic, channel.topic
        robots.add(parts.robot)
        if len(robots) > 1:
            names = ", ".join(sorted(robots))
            raise LogReadError(self.path, f"holds several robots: got {names}, allowed one")

    def _row(self, record: McapMessage, topic: Topic, key: str) -> LoggedRow | None:
        self.start_ns = record.log_time if self.start_ns is None else min(self.start_ns, record.log_time)
        if topic.name not in self._topics:
            return None
        try:
            header, body = codec.decode(topic, record.data)
        except ProtocolError:
            self.refused[topic.name] = self.refused.get(topic.name, 0) + 1
            return None
        if self.scenario is None and isinstance(body, ScenarioInfo):
            self.scenario = _scenario(body.scenario_json)
        return LoggedRow(topic, key, record.log_time, header, body, record.data)


def _scenario(text: str) -> Scenario | None:
    try:
        return Scenario.model_validate_json(text)
    except ValidationError:
        return None
