"""The filter's side of an arming: an unbroken series of inputs, each made for what the ones before it lead to."""

from typing import Final

from passafe_protocol.messages import UNSEQUENCED, PlantInput, PlantPhase, PlantState, Vector

WAITING_NS: Final = 3_000_000_000
"""How long a plant may seem to wait for the first input before a new arming begins: that input may be lost."""

WAITING: Final = PlantPhase.WAITING
RUNNING: Final = PlantPhase.RUNNING


class InputSequencer:
    """Keeps the series unbroken: a period is never left out, and none is decided twice.

    A series ends when the plant says that it was disarmed, or was not armed in time; the next one rests on that very
    state. Until the plant has run out of inputs that this filter did not make, none begins.
    """

    def __init__(self, *, period_ns: int, hold_ns: int, repeats: int) -> None:
        """Start without a series.

        Args:
            period_ns: Period of the plant, ns.
            hold_ns: How long an input may be in force, ns.
            repeats: How many earlier inputs each message repeats.
        """
        self._period_ns = period_ns
        self._hold_ns = hold_ns
        self._repeats = repeats
        self._from_ns: int | None = None
        self._basis_ns = UNSEQUENCED
        self._next_ns = 0
        self._previous_u: Vector = ()

    def restart(self) -> None:
        """Forget the series: the plant is another one."""
        self._from_ns = None

    def begins_with(self, state: PlantState, target_ns: int) -> tuple[int, bool]:
        """Return the plant time of the next input to be made, and whether a new sequence begins with it.

        Args:
            state: The newest plant state.
            target_ns: Plant time of the input that is to be made now, by the schedule. A next time beyond it means
                that nothing is to be made.
        """
        if self._holds(state):
            return self._next_ns, False
        self._from_ns = None
        if state.phase is RUNNING:
            return target_ns + self._period_ns, False
        self._from_ns = self._next_ns = target_ns
        self._basis_ns = state.sequence_break_ns
        self._previous_u = ()
        return target_ns, True

    def message(self, tick: int, u: Vector, effective_ns: int) -> PlantInput:
        """Return the message of the next input."""
        from_ns = effective_ns if self._from_ns is None else self._from_ns
        made = PlantInput(tick, u, effective_ns, self._hold_ns, from_ns, self._basis_ns, self._previous_u)
        self._previous_u = (u + self._previous_u)[: self._repeats * len(u)]
        self._next_ns = effective_ns + self._period_ns
        return made

    def _holds(self, state: PlantState) -> bool:
        """Tell whether the series is still unbroken, as far as the newest state tells."""
        if self._from_ns is None or state.sequence_break_ns != self._basis_ns:
            return False
        if state.phase is RUNNING:
            return True
        if state.phase is WAITING:
            return self._next_ns - self._from_ns < WAITING_NS
        return state.plant_ns < self._from_ns
