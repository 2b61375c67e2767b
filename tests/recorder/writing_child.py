"""Run as a child process: a recorder whose bus makes 4000 messages a second, until a signal ends it.

Arguments: the log to write, and the largest size in bytes that a file may have (0: no limit). Prints the wall
time in ns of the newest message after every drain.
"""

import resource
import sys
import time
from pathlib import Path

from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header
from passafe_protocol.topics import EVENT
from passafe_services.log.chain import Chain
from passafe_services.log.errors import LogFileError
from passafe_services.log.segmented_log import SegmentedLog
from passafe_services.loop.stop import stop_requests
from passafe_services.recorder.background_log import BackgroundLog
from passafe_services.recorder.record_loop import record

PERIOD_NS = 250_000


class Source:
    """Makes the messages that were due since the last drain."""

    def __init__(self) -> None:
        self.sequence = 0
        self.next_ns = time.time_ns()

    def drain(self) -> list[tuple[str, bytes]]:
        """Everything due by now."""
        made = []
        now_ns = time.time_ns()
        while self.next_ns <= now_ns:
            header = Header("plant", 1, self.sequence, 0, 0, 0, self.next_ns)
            text = f"{self.sequence * 2654435761 % 2**64:x}" * 20  # something that does not compress away
            made.append((EVENT.key("plant"), encode(header, Event("info", text))))
            self.sequence += 1
            self.next_ns += PERIOD_NS
        print(self.next_ns - PERIOD_NS, flush=True)  # noqa: T201 - the parent reads it
        return made


def main(path: Path, limit_bytes: int) -> None:
    if limit_bytes:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))
    with stop_requests(lifeline=False) as stop:
        try:
            log = BackgroundLog(SegmentedLog(path, {}, Chain("child")), retry_s=0.05)
            record(Source(), log, publish=lambda *_: None, stop=stop)
        except LogFileError as error:
            sys.exit(str(error))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
