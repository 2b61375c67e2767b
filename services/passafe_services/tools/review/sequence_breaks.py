"""Sequence breaks of a run: intervals in which the plant had no input of the filter."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from passafe_protocol.messages import PlantPhase, PlantState

from passafe_services.log.continuity import LoggedMessage

RUNNING, FAIL_SAFE, WAITING = PlantPhase.RUNNING, PlantPhase.FAIL_SAFE, PlantPhase.WAITING


class SequenceBreak(NamedTuple):
    """Interval in which a running plant applied no input of the filter.

    Times are those of the first state after the change; ``None`` if no state of the log shows it.

    Attributes:
        at_s: Plant time at which an input was missing, s.
        wall_ns: Wall time of the same state, Unix, ns.
        fail_safe_wall_ns: Wall time at which the fail-safe law was in force, ns.
        resumed_wall_ns: Wall time at which an input was applied again, ns.
        resumed_s: Plant time of the same state, s.
    """

    at_s: float
    wall_ns: int
    fail_safe_wall_ns: int | None
    resumed_wall_ns: int | None
    resumed_s: float | None

    def length_s(self, end_s: float) -> float:
        """Return its length, s; without an end in the log, until the end of the log at ``end_s``."""
        return (end_s if self.resumed_s is None else self.resumed_s) - self.at_s


def running_states(states: Sequence[LoggedMessage[PlantState]]) -> Iterator[tuple[bool, int]]:
    """Yield whether an input of the filter was in force, and the plant time, ns, of every state of a moving plant.

    Sessions come in the order in which they ended: of two plants at once, the last one shows how the run ended.

    Args:
        states: All plant states of a log, by session and in order of sequence.
    """
    sessions = [list(session) for _, session in groupby(states, key=lambda state: state.header.epoch)]
    for session in sorted(sessions, key=lambda session: session[-1].header.wall_ns):
        for state in session:
            if state.body.phase is not WAITING:
                yield state.body.phase is RUNNING, state.body.plant_ns


def sequence_breaks(states: Sequence[LoggedMessage[PlantState]]) -> list[SequenceBreak]:
    """Return the sequence breaks of a log, in order.

    Args:
        states: All its plant states, by session and in order of sequence.
    """
    found: list[SequenceBreak] = []
    for _, session in groupby(states, key=lambda state: state.header.epoch):
        found += _of_session(session)
    return found


def _of_session(states: Iterable[LoggedMessage[PlantState]]) -> list[SequenceBreak]:
    moving = (state for state in states if state.body.phase is not WAITING)
    stretches = [(runs, list(of)) for runs, of in groupby(moving, key=lambda state: state.body.phase is RUNNING)]
    found = []
    for index, (runs, without) in enumerate(stretches):
        if runs:
            continue
        begun = without[0]
        law = next((state.header.wall_ns for state in without if state.body.phase is FAIL_SAFE), None)
        again = stretches[index + 1][1][0] if index + 1 < len(stretches) else None
        found.append(
            SequenceBreak(
                at_s=begun.body.plant_ns / 1e9,
                wall_ns=begun.header.wall_ns,
                fail_safe_wall_ns=law,
                resumed_wall_ns=None if again is None else again.header.wall_ns,
                resumed_s=None if again is None else again.body.plant_ns / 1e9,
            )
        )
    return found
