"""Timing of a run, from the times in its headers."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Final, Self

import numpy as np
from passafe_protocol.messages import FilterTick, Header, OperatorCommand, PlantInput, PlantPhase, PlantState
from passafe_protocol.topics import COMMAND
from pydantic import BaseModel, ConfigDict

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S

NS_PER_US: Final = 1e3
NS_PER_MS: Final = 1e6


class Percentiles(BaseModel):
    """Percentiles of a duration, in the unit of the field's name."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    p50: float
    p99: float
    p99_9: float
    max: float

    @classmethod
    def of(cls, durations_ns: IntArray, unit_ns: float) -> Self | None:
        """Return percentiles in units of ``unit_ns``, interpolated linearly; ``None`` without durations."""
        if durations_ns.size == 0:
            return None
        p50, p99, p99_9, largest = np.percentile(durations_ns, [50, 99, 99.9, 100]) / unit_ns
        return cls(p50=p50, p99=p99, p99_9=p99_9, max=largest)


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

    @classmethod
    def of(cls, log: RunLog) -> Self:
        """Return the timing of a run from its log."""
        live = log.identity.driver == "live"
        return cls(
            solve_us=_solve_us(log.of(PlantInput)) if live else None,
            late_us=_late_us(log) if live else None,
            command_age_ms=_age_ms(tick.body.command_age_ns for tick in log.of(FilterTick)),
            state_age_ms=_age_ms(tick.body.state_age_ns for tick in log.of(FilterTick)),
            operator_to_plant_ms=_operator_to_plant_ms(log),
        )


def steps_skipped(ticks: Sequence[LoggedMessage[FilterTick]], period_ns: float) -> int:
    """Return the number of skipped filter steps: gaps in the times at which steps were due.

    Counted between successive ticks only, so that messages missing in the log do not count.
    """
    return _skipped([tick.header for tick in ticks], period_ns)


def _skipped(headers: Sequence[Header], period_ns: float) -> int:
    skipped = 0
    for a, b in pairwise(headers):
        if (a.source, a.epoch, a.sequence + 1) == (b.source, b.epoch, b.sequence):
            skipped += max(round((b.scheduled_ns - a.scheduled_ns) / period_ns) - 1, 0)
    return skipped


def _solve_us(inputs: Sequence[LoggedMessage[PlantInput]]) -> Percentiles | None:
    return Percentiles.of(_ns([i.header.sent_ns - i.header.started_ns for i in inputs]), NS_PER_US)


def _late_us(log: RunLog) -> dict[str, Lateness]:
    headers: dict[str, list[Header]] = {
        "operator": [m.header for m in log.of(OperatorCommand)],
        "filter": [m.header for m in log.of(FilterTick)],
        "plant": [m.header for m in log.of(PlantState)],
    }
    found = {}
    for process, sent in headers.items():
        # A plant that catches up sends several states in one step.
        steps = {(header.epoch, header.scheduled_ns): header for header in sent}.values()
        late_ns = _ns([header.started_ns - header.scheduled_ns for header in steps])
        lateness = Lateness.of(late_ns, NS_PER_US)
        if lateness is not None:
            due = late_ns.size + _skipped(sent, log.identity.scenario.dt_s * NS_PER_S)
            share = float(np.count_nonzero(late_ns <= NS_PER_MS)) / due
            found[process] = lateness.model_copy(update={"within_1_ms": share})
    return found


def _age_ms(ages_ns: Iterable[int]) -> Percentiles | None:
    return Percentiles.of(_ns([age_ns for age_ns in ages_ns if age_ns >= 0]), NS_PER_MS)


def _operator_to_plant_ms(log: RunLog) -> Percentiles | None:
    commands, ticks = log.of(OperatorCommand), log.of(FilterTick)
    states = [state for state in log.of(PlantState) if state.body.phase is not PlantPhase.WAITING]
    if _sessions(ticks) != 1 or _sessions(states) != 1:
        return None  # tick numbers restart with a session and are ambiguous
    if len({command.header.clock_id for command in commands} | {state.header.clock_id for state in states}) > 1:
        return None  # nothing says how far apart the wall clocks of two hosts are
    sent_ns = {(c.header.epoch, c.header.sequence): c.header.wall_ns for c in commands}
    applied = np.maximum.accumulate(_ns([state.body.applied_tick for state in states]))
    begun_ns = [s.header.wall_ns - (s.header.sent_ns - s.header.started_ns) for s in states]
    latencies = []
    for tick in ticks[1:]:  # the first accounts for all commands that came before there was a robot to move
        at = int(np.searchsorted(applied, tick.body.tick))
        if at == len(states):
            break
        latencies += [
            begun_ns[at] - sent_ns[number]
            for consumed in tick.body.consumed
            if consumed.topic == COMMAND.name and (number := (consumed.epoch, consumed.sequence)) in sent_ns
        ]
    return Percentiles.of(_ns(latencies), NS_PER_MS)


def _sessions(sent: Sequence[LoggedMessage[FilterTick]] | Sequence[LoggedMessage[PlantState]]) -> int:
    return len({(message.header.source, message.header.epoch) for message in sent})


def _ns(values: Sequence[int]) -> IntArray:
    return np.array(values, dtype=np.int64)
