"""A run that is to be started: its scenario, log and processes."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.scenarios.schema import Scenario
from passafe_services.session.control_messages import RunChoices


@dataclass(frozen=True, kw_only=True, slots=True)
class PlannedRun:
    """A run that can be started.

    Attributes:
        choices: What it was asked to be.
        scenario: Effective scenario.
        scenario_file: File of it, for its processes.
        log: Log that its recorder writes; ``None``: it is not recorded.
        specs: Its processes, in the order of their start.
        most_s: Longest time that it may take once all are ready, s; ``None``: no limit.
    """

    choices: RunChoices
    scenario: Scenario
    scenario_file: Path
    log: Path | None
    specs: tuple[ProcessSpec, ...]
    most_s: float | None

    def discard(self) -> None:
        """Remove what was written for it, because it is not started."""
        with suppress(OSError):
            self.scenario_file.unlink(missing_ok=True)
