"""Filter node without prediction: decides for the newest plant state, whatever its age."""

from collections.abc import Sequence

from passafe_protocol.messages import PlantInput, PlantPhase, PlantState, Received, Vector
from passafe_protocol.topics import COMMAND, STATE, Topic

from passafe.state_set import StateSet
from passafe_services.filter.decision_loop import DecisionLoop
from passafe_services.filter.predictor import Predicted
from passafe_services.filter.unpredicted_state import UnpredictedState
from passafe_services.node import Outgoing


class UnpredictedFilterNode:
    """Decides and sends one unsequenced input per step (``filter.prediction = false``): shows the effect of delay."""

    name = "filter"
    subscribes: tuple[Topic, ...] = (COMMAND, STATE)
    horizon_ns = 0

    def __init__(self, decisions: DecisionLoop, state: UnpredictedState, *, period_ns: int, hold_ns: int) -> None:
        """Start with nothing received.

        Args:
            decisions: Executes the steps.
            state: State and tank energy for the decisions.
            period_ns: Period of the plant, ns.
            hold_ns: Longest time for which an input may be in force, ns.
        """
        self._decisions = decisions
        self._state = state
        self._period_ns = period_ns
        self._hold_ns = hold_ns
        self._next_ns: int | None = None

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the inputs for the plant and the record of each, see ``DecisionLoop.step``."""
        return self._decisions.step(now_ns, inbox, self)

    def restart(self) -> None:
        """Discard all state: the plant was restarted."""
        self._state.restart()
        self._next_ns = None

    def void(self) -> None:
        """Forget the input sent last: an emergency stop or its clear voids it at the plant."""
        self._state.void()

    def confirm(self, state: PlantState, known: StateSet | None = None) -> None:
        """Keep the newest plant state."""
        del known
        self._state.confirm(state)

    def inputs_between(self, before: PlantState, state: PlantState) -> Sequence[Vector] | None:
        """Return the input between two plant states that follow one another; ``None`` for others."""
        periods = (state.plant_ns - before.plant_ns) // self._period_ns
        return [before.u] * periods if periods <= 1 and before.phase is not PlantPhase.WAITING else None

    def next_input(self, state: PlantState, target_ns: int) -> tuple[int, bool]:
        """Return the plant time of the next input, never one already decided; no sequence begins; see ``InputPath``."""
        del state
        if self._next_ns is None or target_ns >= self._next_ns:
            return target_ns, False
        return self._next_ns, False

    def predict(self, effective_ns: int) -> Predicted:
        """Return the newest plant state, as if the plant still had it when the input takes effect."""
        return self._state.at(effective_ns)

    def message(self, tick: int, u: Vector, effective_ns: int, stops_cleared: int) -> PlantInput:
        """Return the message of the input decided last."""
        self._state.record_sent(u)
        self._next_ns = effective_ns + self._period_ns
        return PlantInput(tick, u, effective_ns, self._hold_ns, stops_cleared=stops_cleared)
