"""Replays the filter of a log: of a file in one pass, or of a log that has been read."""

from collections import deque
from collections.abc import Iterator
from pathlib import Path

from mcap.records import Channel, Metadata
from mcap.records import Message as LogRecord
from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import FilterTick, Header, Message, OperatorCommand, PlantState, ScenarioInfo
from passafe_protocol.topics import COMMAND, SCENARIO, STATE, TICK, Topic

from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import SCENARIO_RECORD, topic_of_key
from passafe_services.tools.replay.filter_replay import KEPT, FilterReplay, Replay
from passafe_services.tools.review.run_identity import identify
from passafe_services.tools.review.run_log import RunLog

_NEEDED = {topic.name for topic in (COMMAND, STATE, TICK, SCENARIO)}


def replay_file(path: Path) -> Replay:
    """Replay the filter of a run in one pass over its log, with bounded memory.

    Raises:
        LogReadError: The file is missing, empty or no MCAP file.
        ScenarioRecordError: It does not say which scenario it is of, or this build cannot read that.
    """
    replay: FilterReplay | None = None
    metadata: dict[str, dict[str, str]] = {}
    before: deque[tuple[Header, Message]] = deque(maxlen=KEPT)  # messages before the scenario is known
    for header, body in _messages(LogReader(path), metadata):
        before.append((header, body))
        if replay is None:
            info = body if isinstance(body, ScenarioInfo) else None
            if info is None and SCENARIO_RECORD not in metadata:
                continue
            replay = FilterReplay(identify(path, metadata, info))
        while before:
            replay.add(*before.popleft())
        if replay.is_over:
            break
    return (replay or FilterReplay(identify(path, metadata, None))).end()


def replay_filter(log: RunLog) -> Replay:
    """Replay the filter of a run whose log has been read."""
    replay = FilterReplay(log.identity)
    bodies: tuple[type[Message], ...] = (OperatorCommand, PlantState, FilterTick)
    messages = [(logged.header, logged.body) for body in bodies for logged in log.of(body)]
    for header, body in sorted(messages, key=lambda message: message[0].wall_ns):
        replay.add(header, body)
    return replay.end()


def _messages(reader: LogReader, metadata: dict[str, dict[str, str]]) -> Iterator[tuple[Header, Message]]:
    """Yield the messages that a replay needs, in the order of the log; add its metadata to ``metadata``."""
    topics: dict[int, Topic] = {}
    for record in reader.records():
        match record:
            case LogRecord() if record.channel_id in topics:
                try:
                    yield decode(topics[record.channel_id], record.data)
                except ProtocolError:
                    continue  # missing, if a tick consumed it
            case Channel():
                topic = topic_of_key(record.topic)
                if topic is not None and topic.name in _NEEDED:
                    topics[record.id] = topic
            case Metadata():
                metadata[record.name] = record.metadata
            case _:
                pass
