"""The recorder as a process: opens the log and the bus, records until somebody ends it."""

import time
from pathlib import Path
from typing import Final

from protocol.messages import Message
from protocol.topics import Topic
from services.recorder.log_writer import LogWriter, RunMetadata
from services.recorder.process import record
from services.recorder.recording import Recording
from services.runtime.bus import open_bus
from services.runtime.endpoint import Endpoint
from services.runtime.outlet import Outlet
from services.runtime.readiness import announce_ready
from services.runtime.realtime import RECORDER_PRIORITY, request_realtime
from services.runtime.stop import stop_requests

NAME: Final = "recorder"


def run_recorder(endpoint: Endpoint, path: Path, metadata: RunMetadata, *, lifeline: bool = False) -> Recording:
    """Record everything on the bus until somebody ends it; main thread only.

    The log is opened first, so that a folder that cannot be written is told before anything else runs; ready
    is announced once nothing that is published from now on can be missed.

    Args:
        endpoint: Where the router listens.
        path: The log to write.
        metadata: Records to begin it with, see ``run_metadata``.
        lifeline: Whether standard input is a lifeline (see ``services.runtime.stop``).

    Returns:
        What was recorded.

    Raises:
        LogWriteError: The log cannot be created, or the disk does not take it any more.
        BusError: There is no router.
    """
    request_realtime(RECORDER_PRIORITY)  # loops that need it more say so if it is refused
    with (
        stop_requests(lifeline=lifeline) as stop,
        LogWriter(path, metadata) as log,
        open_bus(endpoint) as bus,
    ):
        reader = bus.log_reader()
        outlet = Outlet(bus, NAME, time.time_ns())

        def publish(topic: Topic, body: Message, now_ns: int) -> None:
            outlet.publish(topic, body, scheduled_ns=now_ns, started_ns=now_ns)

        announce_ready(NAME)
        return record(reader, log, publish=publish, stop=stop)
