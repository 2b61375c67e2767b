"""Replays the filter of a log: of a file in one pass, or of a log that has been read."""

from pathlib import Path

from passafe_services.log.log_pass import LogPass, Progress
from passafe_services.loop.realtime import paused_garbage_collection
from passafe_services.tools.replay.filter_replay import WANTS, FilterReplay, Replay
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.run_review import identity_of


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
    # A replay makes thousands of objects a slice and no cycles: to look for these again and again takes 3 % of it.
    with paused_garbage_collection() as collect:
        for part in log.slices(WANTS, wanted_only=True):
            replay.take(part)
            collect()
            if replay.is_over:
                break
        return replay.end()


def replay_filter(log: RunLog) -> Replay:
    """Replay the filter of a run whose log has been read."""
    replay = FilterReplay(log.identity)
    for part in log.slices(WANTS):
        replay.take(part)
    return replay.end()
