"""Names of logs."""

from datetime import UTC, datetime
from itertools import count
from pathlib import Path

from passafe_services.scenarios.schema import Scenario


def log_name(scenario: Scenario) -> str:
    """Return the name of the log of a run that begins now, without suffix: scenario, mode and UTC time."""
    return f"{scenario.name}-{scenario.filter.mode}-{datetime.now(UTC).strftime('%Y%m%d-%H%M%S')}"


def log_path(out: Path, scenario: Scenario) -> Path:
    """Return the log that a recorder writes: ``out``, or in a folder a new one, so that a restart replaces none."""
    if not out.is_dir():
        return out
    name = log_name(scenario)
    candidates = (out / f"{name}{'' if number == 1 else f'-{number}'}.mcap" for number in count(1))
    return next(path for path in candidates if not path.exists())
