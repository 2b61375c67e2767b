"""Replays the filter of a log: of a file in one pass, or of a log that has been read."""

from pathlib import Path

from passafe_protocol.messages import FilterTick, Message, OperatorCommand, PlantState
from passafe_protocol.topics import TOPIC_OF_BODY

from passafe_services.log.continuity import LoggedMessage
from passafe_services.log.log_pass import LogPass, LogSlice, Progress
from passafe_services.log.message_columns import RECORD
from passafe_services.tools.replay.filter_replay import FilterReplay, Replay
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.run_review import identity_of

NEEDED: tuple[type[Message], ...] = (OperatorCommand, PlantState, FilterTick)
"""What the filter consumed and what it decided."""


def replay_file(path: Path, *, progress: Progress | None = None) -> Replay:
    """Replay the filter of a run in one pass over its log, with bounded memory.

    Args:
        path: The log: its first file, or a folder that holds one recording.
        progress: As of ``LogPass``.

    Raises:
        LogReadError: The file is missing, empty or no MCAP file.
        ForeignLogError: It has no channel of passafe.
        ScenarioRecordError: It does not say which scenario it is of, or this build cannot read that.
    """
    log = LogPass(path, progress=progress, workers=0)
    replay = FilterReplay(identity_of(log))
    for part in log.slices({TOPIC_OF_BODY[body].name: (RECORD,) for body in NEEDED}):
        for header, body in _in_time(part):
            replay.add(header, body)
        if replay.is_over:
            break
    return replay.end()


def replay_filter(log: RunLog) -> Replay:
    """Replay the filter of a run whose log has been read."""
    replay = FilterReplay(log.identity)
    messages = [logged for body in NEEDED for logged in log.of(body)]
    for header, body in sorted(messages, key=_wall_ns):
        replay.add(header, body)
    return replay.end()


def _in_time(part: LogSlice) -> list[LoggedMessage[Message]]:
    """Return the messages of a slice about as they were published, so that few wait for what they need."""
    blocks = (block for body in NEEDED for block in part.blocks(TOPIC_OF_BODY[body].name))
    return sorted((LoggedMessage(*message) for block in blocks for message in block.objects(RECORD)), key=_wall_ns)


def _wall_ns(message: LoggedMessage[Message]) -> int:
    return message.header.wall_ns
