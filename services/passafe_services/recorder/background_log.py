"""Writes a log in a thread of its own, so that a slow or full disk does not keep the recorder from reading the bus."""

import time
from collections import deque
from collections.abc import Callable
from threading import Condition, Thread
from typing import Final, NamedTuple, Self

from passafe_services.log.chain import RecorderCounts
from passafe_services.log.errors import LogWriteError
from passafe_services.log.segmented_log import RawMessage, SegmentedLog

CAPACITY_BYTES: Final = 64 * 2**20
"""Size of what may wait for the disk; what comes beyond is counted as lost."""
MESSAGE_BYTES: Final = 300
"""What a message takes in memory besides its wire bytes."""
RETRY_S: Final = 1.0
"""Time until a disk that could not be written is tried again; it doubles with every failure."""
MOST_RETRY_S: Final = 30.0


class DiskReport(NamedTuple):
    """Something to tell of the disk: kind, severity and text of an ``Event``."""

    kind: str
    severity: str
    text: str


class _Flush(NamedTuple):
    """Request to make everything before it safe on the disk."""

    counts: RecorderCounts


class BackgroundLog:
    """Log of a recording, written by a thread; its other methods are called by one other thread.

    Args:
        log: The log.
        capacity_bytes: Size of what may wait for the disk.
        retry_s: Time until a disk that could not be written is tried again, s.

    Attributes:
        lost: Messages that were not logged since too many wait for the disk, by key expression.
    """

    def __init__(self, log: SegmentedLog, *, capacity_bytes: int = CAPACITY_BYTES, retry_s: float = RETRY_S) -> None:
        self.lost: dict[str, int] = {}
        self._log = log
        self._capacity = capacity_bytes
        self._retry_s = retry_s
        self._batch: list[RawMessage] = []
        self._queue: deque[list[RawMessage] | _Flush] = deque()
        self._waiting_bytes = 0
        self._changed = Condition()
        self._reports: list[DiskReport] = []
        self._counts = RecorderCounts()
        self._error: LogWriteError | None = None
        self._is_busy = self._closing = False
        self._thread = Thread(target=self._run, name="log")
        self._thread.start()

    def write(self, key: str, data: bytes, *, sequence: int, wall_ns: int) -> None:
        """Log one message; it is handed over by the next ``flush`` or ``hand_over``."""
        self._batch.append(RawMessage(key, data, sequence, wall_ns))

    def hand_over(self) -> None:
        """Hand the messages over to the thread, or count them as lost if too many wait."""
        batch, self._batch = self._batch, []
        size = sum(len(message.data) for message in batch) + MESSAGE_BYTES * len(batch)
        with self._changed:
            if not batch:
                return
            if self._waiting_bytes and self._waiting_bytes + size > self._capacity:
                self._lose(batch)
                return
            self._waiting_bytes += size
            self._queue.append(batch)
            self._changed.notify_all()

    def flush(self, gaps: dict[str, int]) -> None:
        """Let everything logged so far be made safe on the disk.

        Args:
            gaps: Sequence numbers never received so far, by key expression.
        """
        self.hand_over()
        with self._changed:
            if not (self._queue and isinstance(self._queue[-1], _Flush)):  # a slow disk has one before it already
                self._queue.append(_Flush(RecorderCounts(gaps=gaps, lost=dict(self.lost))))
                self._changed.notify_all()

    def take_reports(self) -> list[DiskReport]:
        """Return what is to be reported of the disk since the last call."""
        with self._changed:
            reports, self._reports = self._reports, []
            return reports

    def wait_until_idle(self) -> None:
        """Wait until everything handed over is written."""
        with self._changed:
            self._changed.wait_for(lambda: not (self._queue or self._is_busy) or self._error is not None)

    def close(self, gaps: dict[str, int] | None = None) -> None:
        """Write everything that waits and finish the log; a second call has no effect.

        Raises:
            LogWriteError: The disk cannot be written.
        """
        if self._closing:
            return
        self.flush(gaps or {})
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join()
        if self._error is None:
            self._finish(RecorderCounts(gaps=gaps or {}, lost=dict(self.lost)))
        if self._error is not None:
            raise self._error

    def _finish(self, counts: RecorderCounts) -> None:
        try:
            self._log.close(counts)
        except LogWriteError as error:
            self._error = error

    def _lose(self, batch: list[RawMessage]) -> None:
        for message in batch:
            self.lost[message.key] = self.lost.get(message.key, 0) + 1
        total = sum(self.lost.values())
        text = f"the disk is too slow or full: {total} messages not logged so far, {self._waiting_bytes >> 20} MB wait"
        self._reports.append(DiskReport("lost", "error", text))

    def _run(self) -> None:
        """Write what is handed over until the log is closed."""
        while (item := self._next()) is not None:
            if isinstance(item, _Flush):
                self._counts = item.counts
                self._attempt(lambda: self._log.flush(self._counts))
                continue
            self._attempt(lambda: self._log.write(*item))
            size = sum(len(message.data) for message in item) + MESSAGE_BYTES * len(item)
            with self._changed:
                self._waiting_bytes -= size

    def _next(self) -> list[RawMessage] | _Flush | None:
        with self._changed:
            self._is_busy = False
            self._changed.notify_all()
            self._changed.wait_for(lambda: bool(self._queue) or self._closing)
            if not self._queue or self._error is not None:
                return None
            self._is_busy = True
            return self._queue.popleft()

    def _attempt(self, action: Callable[[], None]) -> None:
        """Write; if the disk refuses, say so and go on in another file as soon as there is one."""
        if self._error is not None:
            return
        begun_ns, path = time.monotonic_ns(), self._log.path
        try:
            action()
        except LogWriteError as error:
            before = f"what was recorded before is in {path}" if path.exists() else f"{path} is gone"
            where = f"{error}; {before}"
            self._report("disk", "error", f"{where}, recording goes on in another file when it can be written")
            self._resume()
        else:
            taken_s = (time.monotonic_ns() - begun_ns) * 1e-9
            if taken_s > RETRY_S:
                self._report("slow", "warning", f"the disk is slow: {taken_s:.1f} s for one write")

    def _resume(self) -> None:
        """Try again until another file can be written; in the end once more."""
        pause_s = self._retry_s
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closing, timeout=pause_s)
                closing = self._closing
            try:
                self._log.reopen(self._counts)
            except LogWriteError as again:
                if closing:
                    with self._changed:
                        self._error = again
                        self._queue.clear()
                    return
                pause_s = min(2 * pause_s, MOST_RETRY_S)
            else:
                self._report("disk-again", "info", f"recording again, in {self._log.path}")
                return

    def _report(self, kind: str, severity: str, text: str) -> None:
        with self._changed:
            self._reports.append(DiskReport(kind, severity, text))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_raised: object) -> None:
        self.close()
