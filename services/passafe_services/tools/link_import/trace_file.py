"""From a file of a measurement to a trace of delays that links read."""

import csv
import gzip
from math import isinf
from pathlib import Path
from typing import Final

from passafe_protocol.link_settings import MAX_DELAY_S

from passafe_services.scenarios.bounded_file import MOST_BYTES, require_bounded, why_unreadable
from passafe_services.scenarios.link_trace import LOST as LOST_WORD
from passafe_services.tools.link_import.errors import MeasurementError
from passafe_services.tools.link_import.irtt_json import Clocks, Direction, read_irtt
from passafe_services.tools.link_import.ping_text import read_ping
from passafe_services.tools.link_import.probes import Measurement

HEADER: Final = ("sent_s", "delay_s")


def read_measurement(
    path: Path,
    *,
    direction: Direction = Direction.SEND,
    clocks: Clocks = Clocks.UNKNOWN,
    interval_s: float | None = None,
) -> Measurement:
    """Return the probes of a file: JSON of irtt, plain or gzip, or text of ping.

    Args:
        path: The file.
        direction: Of irtt: from client to server, or back.
        clocks: Of irtt: whether both clocks are synchronized.
        interval_s: Of ping without times of day: time between probes, s.

    Raises:
        MeasurementError: The file cannot be read, or is neither.
    """
    text = _text(path)
    if text.lstrip().startswith("{"):
        measured = read_irtt(path, text, direction, clocks)
    else:
        measured = read_ping(path, text, interval_s)
    worst_s = max((one.delay_s for one in measured.probes if not isinf(one.delay_s)), default=0.0)
    if worst_s > MAX_DELAY_S:
        raise MeasurementError(path, ", delay", f"{worst_s:.3f} s", f"at most {MAX_DELAY_S:g} s, as a link has it")
    if measured.probes[-1].sent_s <= 0.0:
        raise MeasurementError(path, ", times of sending", "all the same", "some that differ")
    return measured


def write_trace(path: Path, measured: Measurement) -> None:
    """Write the probes as a trace of delays.

    Raises:
        MeasurementError: The file cannot be written.
    """
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(HEADER)
            for sent_s, delay_s in measured.probes:
                writer.writerow((f"{sent_s:.6f}", LOST_WORD if isinf(delay_s) else f"{delay_s:.9f}"))
    except OSError as error:
        raise MeasurementError(path, "", error.strerror, "a file that can be written") from error


def _text(path: Path) -> str:
    try:
        require_bounded(path)
        with path.open("rb") as file:
            is_packed = file.read(2) == b"\x1f\x8b"
        with gzip.open(path) if is_packed else path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise MeasurementError(path, "", f"more than {MOST_BYTES} bytes unpacked", "less")
        return content.decode("utf-8-sig")
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise MeasurementError(path, "", why_unreadable(error), "a readable text file") from error
