"""Health that the loop of a process reports itself, once a second, to whatever supervises it.

A container's health check reads it from a file; systemd receives it as a notification. Both learn what the loop did:
a process whose loop hangs reports nothing, also if its other threads, such as those of a web server, still answer.
"""

import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic_ns
from typing import Final, Self

from passafe_services.loop.service_manager import ALIVE, notify_service_manager, service_manager_listens

SILENCE_S: Final = 3.0
"""Time without a report after which a process is unhealthy, as on the bus (``HEALTH.deadline_s``)."""

LEAST_SHARE: Final = 0.5
"""Share of its steps that a healthy loop executes: below, it no longer controls at its rate."""


@dataclass(frozen=True, kw_only=True, slots=True)
class HealthReport:
    """Report of one process.

    Attributes:
        monotonic_ns: Time of the report by the system's monotonic clock, ns.
        connected: Whether a router is connected.
        executed: Steps executed since the last report.
        skipped: Steps skipped since the last report.
    """

    monotonic_ns: int
    connected: bool
    executed: int
    skipped: int

    def trouble(self, now_ns: int) -> str:
        """Return why the process is unhealthy at ``now_ns``; empty if it is healthy."""
        silent_s = (now_ns - self.monotonic_ns) / 1e9
        if silent_s > SILENCE_S:
            return f"its loop has not reported for {silent_s:.1f} s"
        if not self.connected:
            return "no router is connected"
        if self.executed < LEAST_SHARE * (self.executed + self.skipped):
            return f"its loop skipped {self.skipped} of {self.executed + self.skipped} steps"
        return ""

    @classmethod
    def read(cls, folder: Path, process: str) -> Self | None:
        """Return the last report of a process; ``None`` if there is none that can be read."""
        try:
            return cls(**json.loads(_file(folder, process).read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            return None


class HealthReporter:
    """Reports the health of one process, from its loop.

    Args:
        process: Name of the process.
        folder: Where its report is written for ``passafe health``, on a file system in memory: a disk would delay the
            loop. ``None``: nowhere.
    """

    def __init__(self, process: str, folder: Path | None) -> None:
        self._file = None if folder is None else _file(folder, process)
        self._steps = 0
        self._skipped = 0

    @property
    def wanted(self) -> bool:
        """True if anybody reads the reports: a folder is given, or a service manager."""
        return self._file is not None or service_manager_listens()

    def report(self, *, connected: bool, steps: int, skipped: int) -> None:
        """Report; a folder that cannot be written is left to the check, which then finds an old report.

        Args:
            connected: Whether a router is connected.
            steps: Steps executed so far.
            skipped: Steps skipped so far.
        """
        report = HealthReport(
            monotonic_ns=monotonic_ns(),
            connected=connected,
            executed=steps - self._steps,
            skipped=skipped - self._skipped,
        )
        self._steps, self._skipped = steps, skipped
        state = "connected" if connected else "no router"
        notify_service_manager(ALIVE, f"STATUS={report.executed} steps, {report.skipped} skipped, {state}")
        if self._file is not None:
            unfinished = self._file.with_suffix(".new")
            with suppress(OSError):
                unfinished.write_text(json.dumps(asdict(report)), encoding="utf-8")
                unfinished.replace(self._file)


def _file(folder: Path, process: str) -> Path:
    return folder / f"{process}.json"
