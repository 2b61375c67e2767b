"""Reads a trace of packet delivery times: a CSV file with one column."""

import csv
from pathlib import Path
from typing import Final

from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.link_settings import LinkSettings

from passafe_services.scenarios.bounded_file import require_bounded
from passafe_services.scenarios.errors import LinkTraceError

UNITS_S: Final = {"time_s": 1.0, "time_ms": 1e-3}
"""Unit of each header."""

MAHIMAHI_S: Final = 1e-3
"""Unit without a header, as in traces of Mahimahi."""


def read_trace(path: Path) -> tuple[float, ...]:
    """Return the times of a trace, s.

    Args:
        path: A file with one time per line, in order. A first line ``time_s`` or ``time_ms`` sets the unit; without
            one it is ms.

    Raises:
        LinkTraceError: The file cannot be read, or is not a valid trace.
    """
    try:
        require_bounded(path)
        with path.open(newline="", encoding="utf-8") as file:
            lines = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise LinkTraceError(path, str(error), "a readable CSV file") from error
    unit_s = UNITS_S.get(lines[0][0].strip(), None) if lines else None
    times = lines if unit_s is None else lines[1:]
    try:
        trace_s = tuple(float(cell) * (unit_s or MAHIMAHI_S) for (cell,) in times)
    except ValueError as error:
        allowed = f"one number a line, after a header {' or '.join(UNITS_S)} or none"
        raise LinkTraceError(path, str(error), allowed) from error
    if not trace_s:
        raise LinkTraceError(path, "no times", "at least one")
    try:
        LinkSettings(trace_s=trace_s)
    except LinkSettingsError as error:
        raise LinkTraceError(path, f"{len(trace_s)} times", error.allowed) from error
    return trace_s
