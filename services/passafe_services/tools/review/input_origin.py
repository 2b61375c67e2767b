"""Origin of the inputs in force: decisions of the filter whose ticks are in the log, or somebody else's."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from passafe_protocol.messages import FilterTick, PlantPhase, PlantState

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.trajectory import NS_PER_S

RUNNING = PlantPhase.RUNNING


class ForeignInputs(NamedTuple):
    """States in which an input was in force that no tick in the log decided.

    Attributes:
        states: Their number.
        first_s: Plant time of the first, s.
    """

    states: int
    first_s: float


def foreign_inputs(
    states: Sequence[LoggedMessage[PlantState]], ticks: Iterable[LoggedMessage[FilterTick]]
) -> ForeignInputs | None:
    """Return the states with an input of somebody else than the filter; ``None`` if there is none.

    A tick that is missing in the log decided its input all the same: what is missing is counted elsewhere.

    Args:
        states: All plant states of a log.
        ticks: All its filter ticks.
    """
    decided = {(tick.header.epoch, tick.body.tick): tick.body.u for tick in ticks}
    sessions = {epoch for epoch, _ in decided}
    found = [state.body.plant_ns for state in states if _is_foreign(state.body, decided, sessions)]
    return ForeignInputs(len(found), min(found) / NS_PER_S) if found else None


def _is_foreign(state: PlantState, decided: dict[tuple[int, int], tuple[float, ...]], sessions: set[int]) -> bool:
    epoch = state.input_epoch
    if state.phase is not RUNNING or not epoch:  # 0: a log of an earlier version
        return False
    if epoch not in sessions:
        return True
    return decided.get((epoch, state.applied_tick), state.u) != state.u


def driven_by_the_filter(driven: Property, foreign: ForeignInputs | None) -> Property:
    """Return the property that the robot could be driven, violated if somebody else drove it."""
    if foreign is None:
        return driven
    said = f"the robot was driven by another: {foreign.states} states with an input that no tick of the log decided"
    note = f"{said}, first at {foreign.first_s:.3f} s"
    both = f"{driven.note}, {note}" if driven.note else note
    return driven.model_copy(update={"holds": False, "note": both, "at_s": foreign.first_s})
