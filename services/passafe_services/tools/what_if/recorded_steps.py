"""Steps that the processes of a logged run took, from the headers of their messages."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from passafe_protocol.messages import (
    Event,
    FilterTick,
    Header,
    OperatorLease,
    PlantInput,
    PlantState,
    ScenarioInfo,
)

from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.errors import RerunError

PLANT: Final = "plant"
OPERATOR: Final = "operator"
FILTER: Final = "filter"

BODIES: Final = {PLANT: (PlantState,), FILTER: (FilterTick, PlantInput, ScenarioInfo, OperatorLease, Event)}
"""Messages that show the steps of a process."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Step:
    """One step of a process; times by its own clock.

    Attributes:
        scheduled_ns: Time at which it was due, ns.
        started_ns: Time at which it began, ns.
        sent_ns: Time at which its first message was sent, ns.
        wall_ns: Wall time of that message, ns.
    """

    scheduled_ns: int
    started_ns: int
    sent_ns: int
    wall_ns: int

    @classmethod
    def of(cls, header: Header) -> "Step":
        """Return the step that sent a message."""
        return cls(
            scheduled_ns=header.scheduled_ns,
            started_ns=header.started_ns,
            sent_ns=header.sent_ns,
            wall_ns=header.wall_ns,
        )

    def later(self, by_ns: int) -> "Step":
        """Return a step at another time, which began in time."""
        at_ns = self.scheduled_ns + by_ns
        return Step(scheduled_ns=at_ns, started_ns=at_ns, sent_ns=at_ns, wall_ns=self.wall_ns + at_ns - self.sent_ns)


@dataclass(frozen=True, kw_only=True, slots=True)
class ProcessSession:
    """Steps of a process from its start to its end.

    Attributes:
        process: Name of the process.
        epoch: Epoch of the session.
        clock_id: Clock that it read.
        steps: Its steps in order.
    """

    process: str
    epoch: int
    clock_id: int
    steps: Sequence[Step]

    def at_rate(self, period_ns: int, count: int | None = None) -> "ProcessSession":
        """Return the session with regular steps of another period, from the same first step on.

        Args:
            period_ns: The period, ns.
            count: Number of steps; as many as end with the session if not given.
        """
        first, last = self.steps[0], self.steps[-1]
        number = (last.scheduled_ns - first.scheduled_ns) // period_ns + 1 if count is None else count
        steps = [first.later(k * period_ns) for k in range(number)]
        return ProcessSession(process=self.process, epoch=self.epoch, clock_id=self.clock_id, steps=steps)


def sessions_of(log: RunLog, process: str, period_ns: int) -> list[ProcessSession]:
    """Return the sessions of plant or filter in a log, in order.

    A filter that waits for its first plant state takes steps of which the log shows the first one alone; the others lie
    on the grid of the period.

    Args:
        log: The log.
        process: Plant or filter.
        period_ns: Period of a step, ns.

    Raises:
        RerunError: Two sessions at once.
    """
    headers = [
        message.header for body in BODIES[process] for message in log.of(body) if message.header.source == process
    ]
    by_epoch: dict[int, dict[int, Header]] = {}
    for header in headers:
        known = by_epoch.setdefault(header.epoch, {})
        before = known.get(header.scheduled_ns)
        if before is None or header.sent_ns < before.sent_ns:
            known[header.scheduled_ns] = header
    decided: dict[int, int] = {}
    for tick in log.of(FilterTick):
        decided.setdefault(tick.header.epoch, tick.header.scheduled_ns)
    sessions = [_session(process, epoch, known, decided.get(epoch), period_ns) for epoch, known in by_epoch.items()]
    sessions.sort(key=lambda session: session.steps[0].started_ns)
    for earlier, later in pairwise(sessions):
        if later.steps[0].started_ns <= earlier.steps[-1].started_ns and later.clock_id == earlier.clock_id:
            raise RerunError(log.path, f"cannot be run again: two sessions of the {process} at once")
    return sessions


def _session(
    process: str, epoch: int, known: dict[int, Header], decided_ns: int | None, period_ns: int
) -> ProcessSession:
    ordered = [known[at_ns] for at_ns in sorted(known)]
    steps = [Step.of(header) for header in ordered]
    if decided_ns is not None and process == FILTER:
        steps = [*_waiting(steps, decided_ns, period_ns), *(step for step in steps if step.scheduled_ns >= decided_ns)]
    return ProcessSession(process=process, epoch=epoch, clock_id=ordered[0].clock_id, steps=steps)


def _waiting(known: Sequence[Step], decided_ns: int, period_ns: int) -> list[Step]:
    """Return the steps of a filter before its first tick: those that sent something, and the others of their grid."""
    at = {step.scheduled_ns: step for step in known}
    first = known[0]
    number = (decided_ns - first.scheduled_ns) // period_ns
    due = [decided_ns - k * period_ns for k in range(number, 0, -1)]
    return [at.get(due_ns) or first.later(due_ns - first.scheduled_ns) for due_ns in due]
