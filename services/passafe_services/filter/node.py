"""Filter node: predicts, decides, certifies and sends input sequences."""

from collections.abc import Sequence

from passafe_protocol.messages import PlantInput, PlantState, Received, Vector
from passafe_protocol.topics import COMMAND, STATE, Topic

from passafe.state_set import StateSet
from passafe_services.filter.decision_loop import DecisionLoop
from passafe_services.filter.inexact_predictor import InexactPredictor
from passafe_services.filter.input_sequencer import InputSequencer
from passafe_services.filter.predictor import Predicted, Predictor
from passafe_services.node import Outgoing


class FilterNode:
    """Decides one input per step, for the state that the plant will have when it takes effect.

    A stale or released command (dead-man) fades to u_h = 0 under the same rows. While the plant state is stale nothing
    is sent: the prediction has no basis, and the plant's own fail-safe takes over.
    """

    name = "filter"
    subscribes: tuple[Topic, ...] = (COMMAND, STATE)

    def __init__(
        self, decisions: DecisionLoop, predictor: Predictor | InexactPredictor, sequencer: InputSequencer
    ) -> None:
        """Start with nothing received.

        Args:
            decisions: Executes the steps.
            predictor: Predicts the state at which an input will take effect.
            sequencer: Keeps the input sequence unbroken.
        """
        self._decisions = decisions
        self._predictor = predictor
        self._sequencer = sequencer

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the inputs for the plant and the record of each, see ``DecisionLoop.step``."""
        return self._decisions.step(now_ns, inbox, self)

    @property
    def horizon_ns(self) -> int:
        """Prediction horizon: plant time of the last prediction minus that of the newest plant state, ns."""
        return self._predictor.horizon_ns

    def restart(self) -> None:
        """Discard the prediction and the sequence: the plant was restarted."""
        self._predictor.restart()
        self._sequencer.restart()

    def void(self) -> None:
        """End the sequence: an emergency stop or its clear voids it at the plant."""
        self._sequencer.restart()

    def confirm(self, state: PlantState, known: StateSet | None = None) -> None:
        """Compare the prediction with the newest plant state."""
        predictor = self._predictor
        if isinstance(predictor, InexactPredictor):
            predictor.confirm(state, known)
        else:
            predictor.confirm(state)

    def inputs_between(self, before: PlantState, state: PlantState) -> Sequence[Vector] | None:
        """Return the input of every period between two plant states, see ``InputPath``."""
        predictor = self._predictor
        return predictor.inputs_between(before, state) if isinstance(predictor, InexactPredictor) else None

    def next_input(self, state: PlantState, target_ns: int) -> tuple[int, bool]:
        """Return the plant time of the next input, and whether a new sequence begins with it; see ``InputPath``."""
        first_ns, begins = self._sequencer.next_input(state, target_ns)
        if begins:
            self._predictor.begin_sequence(first_ns)
        return first_ns, begins

    def predict(self, effective_ns: int) -> Predicted:
        """Return the plant at the effective time of an input."""
        return self._predictor.predict(effective_ns)

    def message(self, tick: int, u: Vector, effective_ns: int, stops_cleared: int) -> PlantInput:
        """Return the message of the input decided for the last prediction."""
        self._predictor.record_sent(effective_ns, u)
        return self._sequencer.message(tick, u, effective_ns, stops_cleared)
