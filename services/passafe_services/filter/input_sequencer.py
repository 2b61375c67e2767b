"""Input sequences: one input for every period, each decided for the state to which the previous ones lead."""

from typing import Final

from passafe_protocol.messages import UNSEQUENCED, PlantInput, PlantPhase, PlantState, Vector

WAITING_NS: Final = 3_000_000_000
"""Time after which a new sequence begins if the plant still waits for the first input, which may be lost."""

WAITING: Final = PlantPhase.WAITING
RUNNING: Final = PlantPhase.RUNNING


class InputSequencer:
    """Keeps the input sequence unbroken: no period is skipped, and none is decided twice.

    A sequence ends when the plant reports a break or did not start it in time; the next one starts from that state.
    While the plant still applies inputs of another filter, no sequence begins.
    """

    def __init__(self, *, period_ns: int, hold_ns: int, repeats: int) -> None:
        """Start without a sequence.

        Args:
            period_ns: Period of the plant, ns.
            hold_ns: Longest time for which an input may be in force, ns.
            repeats: Number of previous inputs that each message repeats.
        """
        self._period_ns = period_ns
        self._hold_ns = hold_ns
        self._repeats = repeats
        self._start_ns: int | None = None
        self._break_ns = UNSEQUENCED
        self._next_ns = 0
        self._previous_u: Vector = ()

    def restart(self) -> None:
        """End the sequence: the plant was restarted, or stopped."""
        self._start_ns = None

    def next_input(self, state: PlantState, target_ns: int) -> tuple[int, bool]:
        """Return the plant time of the next input, and whether a new sequence begins with it.

        Args:
            state: The newest plant state.
            target_ns: Plant time of the input that the schedule asks for. If the next input lies beyond it, none is
                due in this step.
        """
        if self._is_unbroken(state):
            return self._next_ns, False
        self._start_ns = None
        if state.phase is RUNNING:
            return target_ns + self._period_ns, False
        self._start_ns = self._next_ns = target_ns
        self._break_ns = state.sequence_break_ns
        self._previous_u = ()
        return target_ns, True

    def message(self, tick: int, u: Vector, effective_ns: int, stops_cleared: int = 0) -> PlantInput:
        """Return the message of the next input, see ``InputPath``."""
        start_ns = effective_ns if self._start_ns is None else self._start_ns
        message = PlantInput(
            tick, u, effective_ns, self._hold_ns, start_ns, self._break_ns, self._previous_u, stops_cleared
        )
        self._previous_u = (u + self._previous_u)[: self._repeats * len(u)]
        self._next_ns = effective_ns + self._period_ns
        return message

    def _is_unbroken(self, state: PlantState) -> bool:
        """Check whether the sequence is unbroken according to the newest state."""
        if self._start_ns is None or state.sequence_break_ns != self._break_ns:
            return False
        if state.phase is RUNNING:
            return True
        if state.phase is WAITING:
            return self._next_ns - self._start_ns < WAITING_NS
        return state.plant_ns < self._start_ns
