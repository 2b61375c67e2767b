"""Reads recorded commands: CSV with columns ``time_s``, ``u_h_0``, ``u_h_1`` and so on."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import Final, NamedTuple

from passafe_protocol.messages import Vector

from passafe_services.operator.errors import RecordingError
from passafe_services.scenarios.bounded_file import require_bounded

TIME_COLUMN: Final = "time_s"
ROWS_MAX: Final = 1_000_000
LARGEST: Final = 1e6
"""Largest time in seconds and largest command in units of u, as in scenarios."""
SPACING_S: Final = 1e-9
"""Smallest time between two rows: the resolution of plant time, so that slopes are finite."""


class CommandRecording(NamedTuple):
    """Recorded commands.

    Attributes:
        times_s: Time of each row, s, from 0 on, increasing by at least ``SPACING_S``.
        values: u_h of each row, units of u.
    """

    times_s: tuple[float, ...]
    values: tuple[Vector, ...]


def load_recording(path: Path, inputs: int) -> CommandRecording:
    """Return the recorded commands in a CSV file.

    Args:
        path: The file: UTF-8, a header line, then one row per instant. Columns may be in any order; blank lines are
            skipped.
        inputs: m, the number of axes.

    Raises:
        RecordingError: The file cannot be opened or is not valid; names line and column.
    """
    try:
        require_bounded(path)
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _read(path, _rows(path, file), inputs)
    except OSError as error:
        raise RecordingError(
            path, line=0, column="", got=error.strerror or str(error), allowed="a readable file"
        ) from error
    except UnicodeDecodeError as error:
        raise RecordingError(
            path, line=0, column="", got=f"byte {error.start} that is no UTF-8", allowed="UTF-8 text"
        ) from error


def _rows(path: Path, file: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and cells of every line that is not blank."""
    reader = csv.reader(file, strict=True)
    try:
        for cells in reader:
            if cells:
                yield reader.line_num, [cell.strip() for cell in cells]
    except csv.Error as error:
        raise RecordingError(
            path, line=reader.line_num, column="", got=str(error), allowed="comma-separated values"
        ) from error


def _read(path: Path, rows: Iterator[tuple[int, list[str]]], inputs: int) -> CommandRecording:
    columns = _columns(path, next(rows, (0, [])), inputs)
    times_s: list[float] = []
    values: list[Vector] = []
    for line, cells in rows:
        if len(cells) != len(columns):
            raise RecordingError(
                path,
                line=line,
                column="",
                got=f"{len(cells)} cells",
                allowed=f"{len(columns)}, as in the header",
            )
        row = {column: _number(path, line, column, cell) for column, cell in zip(columns, cells, strict=True)}
        time_s = row.pop(TIME_COLUMN)
        _check_time(path, line, time_s, times_s)
        if len(times_s) == ROWS_MAX:
            raise RecordingError(path, line=line, column="", got="one more row", allowed=f"{ROWS_MAX} rows")
        times_s.append(time_s)
        values.append(tuple([row[f"u_h_{axis}"] for axis in range(inputs)]))
    if not times_s:
        raise RecordingError(path, line=0, column="", got="no row", allowed="a header and at least one row")
    return CommandRecording(tuple(times_s), tuple(values))


def _columns(path: Path, header: tuple[int, list[str]], inputs: int) -> list[str]:
    line, columns = header
    wanted = [TIME_COLUMN, *(f"u_h_{axis}" for axis in range(inputs))]
    allowed = f"the columns {','.join(wanted)}, one for each of the robot's {inputs} inputs"
    for column in wanted:
        if columns.count(column) != 1:
            raise RecordingError(path, line=line, column=column, got=",".join(columns), allowed=allowed)
    for column in columns:
        if column not in wanted:
            raise RecordingError(path, line=line, column=column, got=",".join(columns), allowed=allowed)
    return columns


def _number(path: Path, line: int, column: str, cell: str) -> float:
    try:
        # Python accepts 1_0 as 10; in a table it is a typing error.
        number = float(cell.replace("_", "?"))
    except ValueError as error:
        raise RecordingError(path, line=line, column=column, got=cell, allowed="a number") from error
    if not isfinite(number) or abs(number) > LARGEST:
        raise RecordingError(
            path,
            line=line,
            column=column,
            got=cell,
            allowed=f"a finite number from {-LARGEST:g} to {LARGEST:g}",
        )
    return number


def _check_time(path: Path, line: int, time_s: float, earlier: Sequence[float]) -> None:
    if time_s < 0.0:
        raise RecordingError(path, line=line, column=TIME_COLUMN, got=time_s, allowed="0 or more")
    if earlier and time_s - earlier[-1] < SPACING_S:
        raise RecordingError(
            path,
            line=line,
            column=TIME_COLUMN,
            got=time_s,
            allowed=f"more than {earlier[-1]} in the row before",
        )
