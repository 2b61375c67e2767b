"""Reads what ``ping`` prints, of Linux with and without ``-D``, of macOS and of Windows."""

import re
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from passafe_protocol.link_settings import MAX_OPPORTUNITIES

from passafe_services.tools.link_import.errors import MeasurementError
from passafe_services.tools.link_import.probes import LOST, Measurement, Probe, from_begin

_NUMBER: Final = r"(\d+(?:\.\d+)?)"
_STAMP: Final = re.compile(rf"^\[{_NUMBER}\]")
_SEQUENCE: Final = re.compile(r"icmp_seq[ =](\d+)")
_TIME: Final = re.compile(rf"time[=<]{_NUMBER} ?ms")
_TOTAL: Final = re.compile(r"^(\d+) packets transmitted.* time (\d+)ms")
_WINDOWS_LOST: Final = re.compile(r"^(Request timed out|.*Destination (host|net) unreachable|General failure)")
_WINDOWS_ANSWER: Final = re.compile(r"^Reply from .*bytes=")
WRAP: Final = 1 << 16
"""``icmp_seq`` has 16 bits."""

DEFAULT_INTERVAL_S: Final = 1.0
"""Time between probes if nothing else is said, as ping sends them."""

LEAST_PROBES: Final = 2


class _Answer(NamedTuple):
    """Answer to a probe, or the word that none came.

    Attributes:
        rtt_s: Round trip, infinite without an answer, s.
        sent_s: Time of day at which the probe was sent, s; ``None`` if the output has none.
    """

    rtt_s: float
    sent_s: float | None


class _Output:
    """Lines of one run of ping, taken in one after the other."""

    def __init__(self, path: Path) -> None:
        self.answers: dict[int, _Answer] = {}
        self.duplicates = self.reordered = 0
        self.total_s = 0.0
        self._path = path
        self._newest = -1

    def take(self, line_number: int, line: str) -> None:
        """Take in a line; one that is about no probe is passed over."""
        total = _TOTAL.search(line)
        if total is not None:
            self.total_s = int(total[2]) * 1e-3
        sequence, time = _SEQUENCE.search(line), _TIME.search(line)
        if sequence is not None:
            if time is None and "time" in line and "timeout" not in line:
                raise MeasurementError(self._path, f", line {line_number}", repr(line[:80]), "time=… ms")
            self._add(self._unwrapped(int(sequence[1])), line, None if time is None else float(time[1]) * 1e-3)
        elif _WINDOWS_ANSWER.match(line) and time is not None:
            self._add(self._newest + 1, line, float(time[1]) * 1e-3)
        elif _WINDOWS_LOST.match(line):
            self._add(self._newest + 1, line, None)

    def _add(self, number: int, line: str, rtt_s: float | None) -> None:
        before = self.answers.get(number)
        if rtt_s is not None and before is not None and before.rtt_s != LOST:
            self.duplicates += 1
            return
        self.reordered += rtt_s is not None and number < self._newest and before is None
        stamp = _STAMP.match(line)
        if rtt_s is None:
            self.answers.setdefault(number, _Answer(LOST, None))  # when it was given up, not when it was sent
        else:
            self.answers[number] = _Answer(rtt_s, None if stamp is None else float(stamp[1]) - rtt_s)
        self._newest = max(self._newest, number)

    def _unwrapped(self, number: int) -> int:
        """Return the number of a probe, of which ping prints the last 16 bits."""
        if self._newest < 0:
            return number
        rounds = round((self._newest - number) / WRAP)
        return number + max(rounds, 0) * WRAP


def read_ping(path: Path, text: str, interval_s: float | None = None) -> Measurement:
    """Return the probes of one direction: half of the round trip, which is all that ping measures.

    Args:
        path: The file, for messages.
        text: Its contents.
        interval_s: Time between probes, s, for output without times of day; otherwise as ping says at its end, or 1 s.

    Raises:
        MeasurementError: It has fewer than two probes, or a line that cannot be read.
    """
    output = _Output(path)
    for line_number, line in enumerate(text.splitlines(), start=1):
        output.take(line_number, line.strip())
    answers = output.answers
    if len(answers) < LEAST_PROBES:
        raise MeasurementError(path, "", f"{len(answers)} probes", "the output of ping with two or more")
    numbers = range(min(answers), max(answers) + 1)
    if len(numbers) > MAX_OPPORTUNITIES:
        raise MeasurementError(path, "", f"numbers of probes over {len(numbers)}", f"at most {MAX_OPPORTUNITIES}")
    assumptions = ["each direction takes half of the round trip"]
    known = {number: one.sent_s for number, one in answers.items() if one.sent_s is not None}
    if len(known) < LEAST_PROBES:
        step_s = interval_s or (output.total_s / (len(numbers) - 1) if output.total_s else DEFAULT_INTERVAL_S)
        assumptions.append(f"one probe was sent every {1e3 * step_s:.4g} ms")
        known = {number: number * step_s for number in (numbers[0], numbers[-1])}
    delays = [answers.get(number, _UNANSWERED).rtt_s / 2.0 for number in numbers]
    if LOST in delays:
        assumptions.append("what got no answer was lost in this direction, not on the way back")
    probes = [Probe(sent_s, delay_s) for sent_s, delay_s in zip(_sent(numbers, known), delays, strict=True)]
    return Measurement(
        probes=from_begin(probes),
        assumptions=tuple(assumptions),
        duplicates=output.duplicates,
        reordered=output.reordered,
    )


_UNANSWERED: Final = _Answer(LOST, None)


def _sent(numbers: range, known: dict[int, float]) -> list[float]:
    """Return the time of sending of every probe, s, between and beyond the known ones along straight lines."""
    at = sorted(known)
    times = np.interp(numbers, at, [known[number] for number in at])
    step_s = (known[at[-1]] - known[at[0]]) / (at[-1] - at[0])
    for k, number in enumerate(numbers):
        if number < at[0]:
            times[k] = known[at[0]] - (at[0] - number) * step_s
        elif number > at[-1]:
            times[k] = known[at[-1]] + (number - at[-1]) * step_s
    return [float(one) for one in times]
