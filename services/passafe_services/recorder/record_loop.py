"""Loop of the recorder: from the bus into the log, flushed often enough that a kill loses at most 300 ms."""

import time
from collections.abc import Callable
from typing import Final, Protocol

from passafe_protocol.messages import Event, Health, Message
from passafe_protocol.sequence_window import WindowSize
from passafe_protocol.topics import EVENT, HEALTH, RECEIPT, Topic

from passafe_services.log.errors import LogWriteError
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog
from passafe_services.loop.recording_reader import CACHED_SAMPLES
from passafe_services.recorder.background_log import BackgroundLog
from passafe_services.recorder.cache_recovery import CacheRecovery, Caches
from passafe_services.recorder.message_recorder import MessageRecorder

DRAIN_RATE_HZ: Final = 50.0
HELD_UP: Final = WindowSize(remembered=CACHED_SAMPLES, burst=CACHED_SAMPLES)
"""What was held up on its way comes at once, up to all that a cache has."""
FLUSH_PERIOD_NS: Final = 150_000_000
"""Together with a drain period, the hand-over and the flush itself below the 300 ms that a kill may lose."""
HEALTH_PERIOD_NS: Final = 1_000_000_000
RECEIPT_PERIOD_NS: Final = 100_000_000
LAST_DRAIN_NS: Final = 500_000_000
"""Longest time to wait for messages in flight after the stop request."""
SETTLE_S: Final = 0.1
"""Silence after which no message is in flight any more."""


class RawReader(Caches, Protocol):
    """Source of messages: the recording reader of the bus."""

    def drain(self) -> list[tuple[str, bytes]]:
        """Return key expression and wire bytes of the messages received since the last call, in order."""
        ...


class StopSignal(Protocol):
    """Stop request of the recorder."""

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for a stop request, at most ``timeout_s``; return whether there was one."""
        ...


Publish = Callable[[Topic, Message, int], object]
"""Publishes a message of the recorder itself; the last argument is the start of its step, monotonic, ns."""


def record(
    reader: RawReader,
    log: BackgroundLog,
    *,
    publish: Publish,
    stop: StopSignal,
    pause: Callable[[float], None] = time.sleep,
    monotonic_ns: Callable[[], int] = time.monotonic_ns,
    wall_ns: Callable[[], int] = time.time_ns,
) -> MessageRecorder:
    """Log all messages until a stop request, then those still in flight, and finish the file.

    Drains ``DRAIN_RATE_HZ`` times a second, flushes every ``FLUSH_PERIOD_NS``, publishes a Receipt every
    ``RECEIPT_PERIOD_NS``, Health once per second, and an Event when messages are missing, or when the disk is slow,
    full, or can be written again.

    Args:
        reader: Source of the messages.
        log: Log to write to; closed on return and on errors.
        publish: Publishes a message of the recorder itself.
        stop: Stop request.
        pause: Sleeps for a number of seconds.
        monotonic_ns: Clock of the loop.
        wall_ns: Clock for messages without a valid header.

    Returns:
        The recorder with its counts.

    Raises:
        LogWriteError: The log cannot be written in the end; an Event has reported it.
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
            log.close(loop.recording.gaps())
    except LogWriteError as error:
        loop.report("end", "error", str(error), monotonic_ns())
        raise
    return loop.recording


class _Loop:
    """One run of the recorder: drains, flushes and reports when due."""

    def __init__(
        self,
        reader: RawReader,
        log: BackgroundLog,
        publish: Publish,
        monotonic_ns: Callable[[], int],
        wall_ns: Callable[[], int],
    ) -> None:
        self.recording = MessageRecorder(log, HELD_UP)
        self._reader = reader
        self._recovery = CacheRecovery(reader)
        self._log = log
        self._publish = publish
        self._monotonic_ns = monotonic_ns
        self._wall_ns = wall_ns
        self._rate_limited_log = RateLimitedLog()
        self._flushed_ns = self._reported_ns = self._acknowledged_ns = monotonic_ns()
        self._steps_reported = 0
        self._gaps_reported = self._others_reported = 0
        self.pace = Pace(self._reported_ns, DRAIN_RATE_HZ)

    @property
    def time_left_s(self) -> float:
        """Time until the next step is due, s."""
        return max(self.pace.due_ns - self._monotonic_ns(), 0) * 1e-9

    def drain(self) -> int:
        """Log the messages received, and those missed that publishers' caches still have; return their number."""
        samples = self._reader.drain()
        self.recording.record(samples, self._wall_ns(), self._monotonic_ns())
        missed = self._recovery.drain(self._monotonic_ns())
        self.recording.record_missed(missed, self._wall_ns(), self._monotonic_ns())
        self._recovery.ask(self.recording.missing(), self._monotonic_ns())
        self._log.hand_over()
        return len(samples) + len(missed)

    def step(self) -> None:
        """Drain; flush and report if due."""
        now_ns = self._monotonic_ns()
        self.pace.begin(now_ns)
        self.drain()
        if now_ns - self._acknowledged_ns >= RECEIPT_PERIOD_NS:
            self._publish(RECEIPT, self.recording.receipt(self._recovery.expects), now_ns)
            self._acknowledged_ns = now_ns
        if now_ns - self._flushed_ns >= FLUSH_PERIOD_NS:
            self._log.flush(self.recording.gaps())
            self._flushed_ns = now_ns
            for report in self._log.take_reports():
                self.report(*report, now_ns)
        if now_ns - self._reported_ns >= HEALTH_PERIOD_NS:
            self._publish_health(now_ns)
        self.pace.end(self._monotonic_ns())

    def _publish_health(self, now_ns: int) -> None:
        elapsed_s = (now_ns - self._reported_ns) * 1e-9
        health = Health(
            rate_hz=(self.pace.steps - self._steps_reported) / elapsed_s,
            steps=self.pace.steps,
            overruns=self.pace.overruns,
            steps_skipped=self.pace.skipped,
            late_us_max=self.pace.pop_max_lateness_ns() / 1e3,
            topics=self.recording.health(),
        )
        self._reported_ns, self._steps_reported = now_ns, self.pace.steps
        self._publish(HEALTH, health, now_ns)
        gaps = self.recording.gaps()
        total = sum(gaps.values())
        if total > self._gaps_reported:
            missing = ", ".join(f"{key} {number}" for key, number in gaps.items())
            self.report("gaps", "warning", f"messages missing in the log so far: {missing}", now_ns)
        self._gaps_reported = total
        others = self.recording.others
        if others > self._others_reported:
            text = f"messages that are none of the topic table's, not logged so far: {others}, the last one "
            self.report("others", "warning", text + self.recording.last_other, now_ns)
        self._others_reported = others

    def report(self, kind: str, severity: str, text: str, now_ns: int) -> None:
        """Log a message and publish it as an event, within the limits of ``RateLimitedLog``."""
        event: Event | None = self._rate_limited_log.report(kind, severity, text, now_ns)
        if event is not None:
            self._publish(EVENT, event, now_ns)
