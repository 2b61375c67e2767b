"""The recorder's loop: off the bus, into the log, flushed so often that a kill loses at most 300 ms."""

import time
from collections.abc import Callable
from typing import Final, Protocol

from passafe_protocol.messages import Event, Health, Message
from passafe_protocol.topics import EVENT, HEALTH, Topic

from passafe_services.log.errors import LogWriteError
from passafe_services.log.log_writer import LogWriter
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog
from passafe_services.recorder.message_recorder import MessageRecorder

DRAIN_RATE_HZ: Final = 50.0
FLUSH_PERIOD_NS: Final = 200_000_000
"""With a drain period and the flush itself this stays below the 300 ms that a kill may lose."""
HEALTH_PERIOD_NS: Final = 1_000_000_000
LAST_DRAIN_NS: Final = 500_000_000
"""How long messages that are still on their way are waited for after the recorder was told to stop."""
SETTLE_S: Final = 0.1
"""Nothing for so long means that nothing is on its way any more."""


class RawReader(Protocol):
    """Where messages come from: the bus's log reader."""

    def drain(self) -> list[tuple[str, bytes]]:
        """Key expression and wire bytes of everything that arrived since the last call, in order."""
        ...


class StopSignal(Protocol):
    """How the recorder is told to stop."""

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until told to stop, or for ``timeout_s``; return whether told."""
        ...


Publish = Callable[[Topic, Message, int], object]
"""Publishes a message of the recorder's own, made by a step that began at the monotonic time given, ns."""


def record(
    reader: RawReader,
    log: LogWriter,
    *,
    publish: Publish,
    stop: StopSignal,
    pause: Callable[[float], None] = time.sleep,
    monotonic_ns: Callable[[], int] = time.monotonic_ns,
    wall_ns: Callable[[], int] = time.time_ns,
) -> MessageRecorder:
    """Log everything that arrives until told to stop, then what is still on its way, and finish the file.

    Drains ``DRAIN_RATE_HZ`` times a second, flushes every ``FLUSH_PERIOD_NS``, publishes Health once per
    second and an Event when messages turn out to be missing.

    Args:
        reader: Where messages come from.
        log: Where they go; closed on return, also when something fails.
        publish: Publishes a message of the recorder's own.
        stop: Says when to stop.
        pause: Waits so many seconds.
        monotonic_ns: Clock of the loop.
        wall_ns: Clock for messages that do not tell their own time.

    Returns:
        What was recorded.

    Raises:
        LogWriteError: The disk does not take the log any more; an Event has told so.
    """
    loop = _Loop(reader, log, publish, monotonic_ns, wall_ns)
    try:
        with log:
            while not stop.wait(loop.time_left_s):
                loop.step()
            until_ns = monotonic_ns() + LAST_DRAIN_NS
            arriving = True
            while arriving and monotonic_ns() < until_ns:
                pause(SETTLE_S)
                arriving = loop.drain() > 0
    except LogWriteError as error:
        loop.tell("disk", "error", str(error), monotonic_ns())
        raise
    return loop.recording


class _Loop:
    """One run of the recorder: what is due when."""

    def __init__(
        self,
        reader: RawReader,
        log: LogWriter,
        publish: Publish,
        monotonic_ns: Callable[[], int],
        wall_ns: Callable[[], int],
    ) -> None:
        self.recording = MessageRecorder(log)
        self._reader = reader
        self._log = log
        self._publish = publish
        self._monotonic_ns = monotonic_ns
        self._wall_ns = wall_ns
        self._notices = RateLimitedLog()
        self._flushed_ns = self._reported_ns = monotonic_ns()
        self._steps_reported = 0
        self._gaps_told = 0
        self.pace = Pace(self._reported_ns, DRAIN_RATE_HZ)

    @property
    def time_left_s(self) -> float:
        """Time until the next step is due, s."""
        return max(self.pace.due_ns - self._monotonic_ns(), 0) * 1e-9

    def drain(self) -> int:
        """Log what has arrived; return how many messages that were."""
        samples = self._reader.drain()
        self.recording.take(samples, self._wall_ns())
        return len(samples)

    def step(self) -> None:
        """Drain, and do what else is due."""
        now_ns = self._monotonic_ns()
        self.pace.begin(now_ns)
        self.drain()
        if now_ns - self._flushed_ns >= FLUSH_PERIOD_NS:
            self._log.flush()
            self._flushed_ns = now_ns
        if now_ns - self._reported_ns >= HEALTH_PERIOD_NS:
            self._report(now_ns)
        self.pace.end(self._monotonic_ns())

    def _report(self, now_ns: int) -> None:
        elapsed_s = (now_ns - self._reported_ns) * 1e-9
        health = Health(
            rate_hz=(self.pace.steps - self._steps_reported) / elapsed_s,
            steps=self.pace.steps,
            overruns=self.pace.overruns,
            steps_skipped=self.pace.missed,
            late_us_max=self.pace.take_worst_late_ns() / 1e3,
            topics=self.recording.health(),
        )
        self._reported_ns, self._steps_reported = now_ns, self.pace.steps
        self._publish(HEALTH, health, now_ns)
        gaps = self.recording.gaps()
        total = sum(gaps.values())
        if total > self._gaps_told:
            where = ", ".join(f"{key} {number}" for key, number in gaps.items())
            self.tell("gaps", "warning", f"messages missing in the log so far: {where}", now_ns)
        self._gaps_told = total

    def tell(self, kind: str, severity: str, text: str, now_ns: int) -> None:
        """Say something in words, unless the same kind of thing was said a moment ago."""
        event: Event | None = self._notices.notice(kind, severity, text, now_ns)
        if event is not None:
            self._publish(EVENT, event, now_ns)
