"""Emergency stops of a run: when they were latched at the plant, by whom, and until when."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

from passafe_protocol.messages import PlantState

from passafe_services.log.continuity import LoggedMessage
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
        stretches = [(latched, list(of)) for latched, of in groupby(session, key=lambda state: state.body.stop != 0)]
        for index, (latched, of) in enumerate(stretches):
            if latched:
                after = stretches[index + 1][1][0] if index + 1 < len(stretches) else None
                begun, end = of[0].body, (of[-1] if after is None else after).body
                length_s = (end.plant_ns - begun.plant_ns) / NS_PER_S
                found.append(StopStretch(begun.plant_ns / NS_PER_S, length_s, begun.stop_source, after is not None))
    return found


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
