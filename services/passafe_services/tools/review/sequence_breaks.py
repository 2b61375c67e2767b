"""Sequence breaks of a run: intervals in which the plant had no input of the filter."""

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
from passafe_protocol.messages import PlantPhase, PlantState

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.filter_claims import IntArray

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
        of_session = list(session)
        record = BreakRecord()
        record.add(
            np.array([state.body.plant_ns for state in of_session], dtype=np.int64),
            np.array([state.header.wall_ns for state in of_session], dtype=np.int64),
            np.array([state.body.phase for state in of_session], dtype=np.int64),
        )
        found += record.breaks()
    return found


class BreakRecord:
    """Sequence breaks of one session of the plant, from its states as they come."""

    def __init__(self) -> None:
        self._ended: list[SequenceBreak] = []
        self._open: SequenceBreak | None = None
        self.end_s = 0.0

    def add(self, plant_ns: IntArray, wall_ns: IntArray, phase: IntArray) -> None:
        """Add states in order: plant times, ns, wall times, ns, and numbers of their phases, shape (N,) each."""
        moving = phase != WAITING
        plant_ns, wall_ns, phase = plant_ns[moving], wall_ns[moving], phase[moving]
        if not phase.size:
            return
        self.end_s = float(plant_ns[-1] / 1e9)
        runs = phase == RUNNING
        begins = [0, *(np.flatnonzero(runs[1:] != runs[:-1]) + 1).tolist()]
        for begin, end in pairwise([*begins, phase.size]):
            if runs[begin]:
                self._close(int(plant_ns[begin]), int(wall_ns[begin]))
                continue
            if self._open is None:
                self._open = SequenceBreak(int(plant_ns[begin]) / 1e9, int(wall_ns[begin]), None, None, None)
            (law,) = np.nonzero(phase[begin:end] == FAIL_SAFE)
            if law.size and self._open.fail_safe_wall_ns is None:
                self._open = self._open._replace(fail_safe_wall_ns=int(wall_ns[begin + law[0]]))

    def breaks(self) -> list[SequenceBreak]:
        """Return the breaks so far, in order."""
        return [*self._ended, *([] if self._open is None else [self._open])]

    @property
    def without_input_s(self) -> float:
        """Plant time without an input, s."""
        return sum(one.length_s(self.end_s) for one in self.breaks())

    def _close(self, plant_ns: int, wall_ns: int) -> None:
        if self._open is not None:
            self._ended.append(self._open._replace(resumed_wall_ns=wall_ns, resumed_s=plant_ns / 1e9))
            self._open = None
