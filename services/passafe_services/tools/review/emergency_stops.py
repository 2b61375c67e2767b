"""Emergency stops of a run: when they were latched at the plant, by whom, and until when."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantState

from passafe_services.log.column import Texts
from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.trajectory import NS_PER_S


class StopStretch(NamedTuple):
    """Stretch of a session of the plant in which an emergency stop was latched.

    Attributes:
        at_s: Plant time of its first state, s.
        length_s: Plant time to the first state after it, or to the last one of the session, s.
        source: Process that pressed it.
        is_cleared: Whether it was cleared.
    """

    at_s: float
    length_s: float
    source: str
    is_cleared: bool


def emergency_stops(states: Sequence[LoggedMessage[PlantState]]) -> list[StopStretch]:
    """Return the emergency stops of a log, in order.

    Args:
        states: All its plant states, by session and in order of sequence.
    """
    found: list[StopStretch] = []
    for _, session in groupby(states, key=lambda state: state.header.epoch):
        record = StopRecord()
        for state in session:
            record.add(state.body.plant_ns, state.body.stop_source if state.body.stop else None)
        found += record.stretches()
    return found


class StopRecord:
    """Emergency stops of one session of the plant, from its states as they come."""

    def __init__(self) -> None:
        self._ended: list[StopStretch] = []
        self._begun: tuple[int, str] | None = None
        self._newest_ns = 0

    def add(self, plant_ns: int, source: str | None) -> None:
        """Add a state: its plant time, ns, and who pressed the stop that is latched; ``None`` without one."""
        self._newest_ns = plant_ns
        if source is not None and self._begun is None:
            self._begun = plant_ns, source
        elif source is None and self._begun is not None:
            self._ended.append(self._stretch(*self._begun, is_cleared=True))
            self._begun = None

    def add_all(self, plant_ns: IntArray, latched: NDArray[np.bool_], sources: Texts) -> None:
        """Add states in order: plant times, ns, whether a stop is latched, and who pressed it; at least one."""
        if not isinstance(sources.codes, np.ndarray):
            raise TypeError("sources: got lists, allowed texts")
        changes = np.flatnonzero(latched != np.concatenate(([self._begun is not None], latched[:-1])))
        for row in changes.tolist():
            self.add(int(plant_ns[row]), sources.words[sources.codes[row]] if latched[row] else None)
        self._newest_ns = int(plant_ns[-1])

    def stretches(self) -> list[StopStretch]:
        """Return the stops so far, in order."""
        return [*self._ended, *([] if self._begun is None else [self._stretch(*self._begun, is_cleared=False)])]

    def _stretch(self, begun_ns: int, source: str, *, is_cleared: bool) -> StopStretch:
        return StopStretch(begun_ns / NS_PER_S, (self._newest_ns - begun_ns) / NS_PER_S, source, is_cleared)


def driven_but_for_stops(driven: Property, stops: Sequence[StopStretch]) -> Property:
    """Return the property that the robot could be driven, with its emergency stops; violated if one was not cleared."""
    if not stops:
        return driven
    said = [
        f"an emergency stop ({stop.source}) was latched from {stop.at_s:.3f} s on "
        + (f"for {stop.length_s:.3g} s" if stop.is_cleared else "and not cleared")
        for stop in (stops[0], *([stops[-1]] if len(stops) > 1 else []))
    ]
    between = len(stops) - 2
    if between > 0:
        said.insert(1, f"{between} more were latched and cleared")
    note = ", ".join([*said, *([driven.note] if driven.note else [])])
    holds = False if not all(stop.is_cleared for stop in stops) else driven.holds
    return driven.model_copy(update={"holds": holds, "note": note})
