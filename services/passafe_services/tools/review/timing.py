"""Timing of a run, from the times in its headers."""

from collections.abc import Mapping
from typing import ClassVar, Final

import numpy as np
from passafe_protocol.topics import COMMAND, INPUT, STATE, TICK, Topic
from pydantic import BaseModel, ConfigDict

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.command_latency import CommandLatency
from passafe_services.tools.review.duration_histogram import DurationHistogram
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S

NS_PER_US: Final = 1e3
NS_PER_MS: Final = 1e6


_STEP: Final = ("header.scheduled_ns", "header.started_ns")
_AGES: Final = ("command_age_ns", "state_age_ns")
_PROCESSES: Final[Mapping[str, Topic]] = {"operator": COMMAND, "filter": TICK, "plant": STATE}


class Percentiles(BaseModel):
    """Percentiles of a duration, in the unit of the field's name."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    p50: float
    p99: float
    p99_9: float
    max: float


class Lateness(Percentiles):
    """Lateness of one process's steps, µs.

    Attributes:
        within_1_ms: Share of the due steps that began within 1 ms of their time; skipped steps did not.
    """

    within_1_ms: float = 0.0


class Timing(BaseModel):
    """Timing of a run; quantities of real time are ``None`` for a lockstep log.

    Attributes:
        solve_us: Time from the beginning of a filter step until its input is handed to the bus, decoding included.
        late_us: Lateness of the steps, by process.
        command_age_ms: Age of the newest operator command at each filter tick, its time on the way included.
        state_age_ms: Age of the newest plant state at each filter tick, likewise.
        operator_to_plant_ms: Latency from sending a command to the first plant step that applied an input based on it,
            play-out included, by the senders' wall clocks; ``None`` for hosts whose clocks are not one.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    solve_us: Percentiles | None
    late_us: dict[str, Lateness] | None
    command_age_ms: Percentiles | None
    state_age_ms: Percentiles | None
    operator_to_plant_ms: Percentiles | None

    @staticmethod
    def of(log: RunLog) -> "Timing":
        """Return the timing of a run from its log."""
        record = TimingRecord(is_live=log.identity.driver == "live", period_ns=log.identity.scenario.dt_s * NS_PER_S)
        for part in log.slices(TimingRecord.wants):
            record.take(part)
        return record.timing()


class StepRecord:
    """Steps of one process: how late they began, and how many were skipped.

    Args:
        period_ns: Period of a step, ns.

    Attributes:
        skipped: Steps skipped to catch up: gaps in the times at which steps were due, counted between successive
            messages only, so that messages missing in the log do not count.
    """

    def __init__(self, period_ns: float) -> None:
        self._period_ns = period_ns
        self._late = DurationHistogram()
        self._in_time = 0
        self._newest: dict[tuple[str, int], tuple[int, int, int]] = {}
        self.skipped = 0

    def take(self, block: MessageBlock) -> None:
        """Take messages of the process, one a step or several."""
        key = (block.source, block.epoch)
        sequence = block.sequence.astype(np.float64)
        due_ns, begun_ns = block.numbers("header.scheduled_ns"), block.numbers("header.started_ns")
        if key in self._newest:
            number, due, begun = self._newest[key]
            sequence = np.concatenate(([number], sequence))
            due_ns, begun_ns = np.concatenate(([due], due_ns)), np.concatenate(([begun], begun_ns))
        follows = np.diff(sequence) == 1.0
        steps = np.rint(np.diff(due_ns)[follows] / self._period_ns) - 1
        self.skipped += int(np.maximum(steps, 0).sum())
        is_last = np.diff(due_ns) != 0  # a plant that catches up sends several states in one step
        self._add(begun_ns[:-1][is_last] - due_ns[:-1][is_last])
        self._newest[key] = int(sequence[-1]), int(due_ns[-1]), int(begun_ns[-1])

    def lateness(self) -> Lateness | None:
        """Return the lateness of all steps; ``None`` without a step. Nothing may be taken after it."""
        self._add(np.array([begun - due for _, due, begun in self._newest.values()], dtype=np.int64))
        self._newest = {}
        found = percentiles_of(self._late, NS_PER_US)
        if found is None:
            return None
        return Lateness(**found.model_dump(), within_1_ms=self._in_time / (self._late.total + self.skipped))

    def _add(self, late_ns: IntArray) -> None:
        self._late.add(late_ns)
        self._in_time += int(np.count_nonzero(late_ns <= NS_PER_MS))


class TimingRecord:
    """Timing of a run, as its messages come.

    Args:
        is_live: Whether it ran in real time.
        period_ns: Period of a step, ns.
    """

    wants: ClassVar[Wants] = {
        COMMAND.name: (*_STEP, "header.clock_id"),
        INPUT.name: ("header.started_ns", "header.sent_ns"),
        STATE.name: (*_STEP, "header.sent_ns", "header.clock_id", "applied_tick", "phase"),
        TICK.name: (*_STEP, "tick", *_AGES, "consumed.topic", "consumed.epoch", "consumed.sequence"),
    }

    def __init__(self, *, is_live: bool, period_ns: float) -> None:
        self._is_live = is_live
        self._steps = {process: StepRecord(period_ns) for process in _PROCESSES}
        self._solve, self._command_age, self._state_age = (DurationHistogram() for _ in range(3))
        self._latency = CommandLatency()

    @property
    def steps_skipped(self) -> int:
        """Steps that the filter skipped to catch up."""
        return self._steps["filter"].skipped

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for process, topic in _PROCESSES.items():
            for block in part.blocks(topic.name):
                self._steps[process].take(block)
        for block in part.blocks(INPUT.name):
            self._solve.add(block.numbers("header.sent_ns") - block.numbers("header.started_ns"))
        for block in part.blocks(TICK.name):
            for age, path in zip((self._command_age, self._state_age), _AGES, strict=True):
                ages_ns = block.numbers(path)
                age.add(ages_ns[ages_ns >= 0])
        self._latency.take(part)

    def timing(self) -> Timing:
        """Return the timing; nothing may be taken after it."""
        late = {process: steps.lateness() for process, steps in self._steps.items()}
        return Timing(
            solve_us=percentiles_of(self._solve, NS_PER_US) if self._is_live else None,
            late_us={process: one for process, one in late.items() if one is not None} if self._is_live else None,
            command_age_ms=percentiles_of(self._command_age, NS_PER_MS),
            state_age_ms=percentiles_of(self._state_age, NS_PER_MS),
            operator_to_plant_ms=percentiles_of(self._latency.histogram(), NS_PER_MS),
        )


def percentiles_of(durations: DurationHistogram, unit_ns: float) -> Percentiles | None:
    """Return percentiles of durations in units of ``unit_ns``; ``None`` without durations."""
    if durations.largest_ns is None:
        return None
    p50, p99, p99_9 = (value_ns / unit_ns for value_ns in durations.percentiles(50, 99, 99.9))
    return Percentiles(p50=p50, p99=p99, p99_9=p99_9, max=durations.largest_ns / unit_ns)
