"""Reads a trace of a network from a CSV file: times at which it delivers, or the delays of what was sent."""

import csv
from math import inf
from pathlib import Path
from typing import Final, NamedTuple

from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.link_settings import LinkSettings, Span

from passafe_services.scenarios.bounded_file import require_bounded, why_unreadable
from passafe_services.scenarios.errors import LinkTraceError

UNITS_S: Final = {"time_s": 1.0, "time_ms": 1e-3}
"""Unit of each header of a trace of deliveries."""

SENT_UNITS_S: Final = {"sent_s": 1.0, "sent_ms": 1e-3}
DELAY_UNITS_S: Final = {"delay_s": 1.0, "delay_ms": 1e-3}
"""Units of the two columns of a trace of delays."""

LOST: Final = "lost"
"""In the place of a delay: what was sent then did not arrive."""

MAHIMAHI_S: Final = 1e-3
"""Unit without a header, as in traces of Mahimahi."""


class LinkTrace(NamedTuple):
    """Contents of a trace.

    Attributes:
        trace_s: Times of deliveries, s.
        delay_trace_s: Pairs of a time of sending and a delay, s, infinite for what was lost.
    """

    trace_s: tuple[float, ...] = ()
    delay_trace_s: tuple[Span, ...] = ()


NO_TRACE: Final = LinkTrace()


def read_trace(path: Path) -> LinkTrace:
    """Return the contents of a trace.

    Args:
        path: A file with one time per line, in order. A first line ``time_s`` or ``time_ms`` sets the unit; without
            one it is ms. Or with a first line ``sent_s,delay_s`` (or ``_ms``): a time of sending and a delay, or
            ``lost``, per line.

    Raises:
        LinkTraceError: The file cannot be read, or is not a valid trace.
    """
    try:
        require_bounded(path)
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [(number, row) for number, row in enumerate(csv.reader(file), start=1) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise LinkTraceError(path, why_unreadable(error), "a readable CSV file") from error
    is_of_delays = bool(lines) and len(lines[0][1]) > 1
    trace = LinkTrace(delay_trace_s=_delays(path, lines)) if is_of_delays else LinkTrace(trace_s=_times(path, lines))
    if not any(trace):
        raise LinkTraceError(path, "no times", "at least one")
    try:
        LinkSettings(**trace._asdict())
    except LinkSettingsError as error:
        raise LinkTraceError(path, f"{len(trace.trace_s or trace.delay_trace_s)} times", error.allowed) from error
    return trace


def _times(path: Path, lines: list[tuple[int, list[str]]]) -> tuple[float, ...]:
    unit_s = UNITS_S.get(lines[0][1][0].strip()) if lines else None
    allowed = f"one number a line, after a header {' or '.join(UNITS_S)} or none"
    times = []
    for number, row in lines if unit_s is None else lines[1:]:
        if len(row) != 1:
            raise LinkTraceError(path, f"line {number}: {len(row)} columns", allowed)
        times.append(_number(path, number, row[0], allowed) * (unit_s or MAHIMAHI_S))
    return tuple(times)


def _delays(path: Path, lines: list[tuple[int, list[str]]]) -> tuple[Span, ...]:
    (_, header), *rows = lines
    names = [name.strip() for name in header]
    if len(names) != len(SENT_UNITS_S) or names[0] not in SENT_UNITS_S or names[1] not in DELAY_UNITS_S:
        raise LinkTraceError(path, f"a header {','.join(names)}", "sent_s,delay_s or sent_ms,delay_ms")
    sent_unit_s, delay_unit_s = SENT_UNITS_S[names[0]], DELAY_UNITS_S[names[1]]
    allowed = f"a time of sending, not before the one before, and a delay or {LOST}"
    found: list[Span] = []
    for number, row in rows:
        if len(row) != len(names):
            raise LinkTraceError(path, f"line {number}: {len(row)} columns", allowed)
        sent_s = _number(path, number, row[0], allowed) * sent_unit_s
        delay_s = inf if row[1].strip() == LOST else _number(path, number, row[1], allowed) * delay_unit_s
        if found and sent_s < found[-1][0]:
            raise LinkTraceError(path, f"line {number}: {row[0]} after {found[-1][0]:g} s", allowed)
        found.append((sent_s, delay_s))
    begin_s = found[0][0] if found else 0.0
    return tuple((sent_s - begin_s, delay_s) for sent_s, delay_s in found)


def _number(path: Path, line: int, text: str, allowed: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise LinkTraceError(path, f"line {line}: {text!r}", allowed) from error
    if not -inf < value < inf:
        raise LinkTraceError(path, f"line {line}: {text!r}", allowed)
    return value
