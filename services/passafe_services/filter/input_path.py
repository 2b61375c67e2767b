"""Interface of a filter node, with or without prediction, to the loop that both share."""

from collections.abc import Sequence
from typing import Protocol

from passafe_protocol.messages import PlantInput, PlantState, Vector

from passafe.state_set import StateSet
from passafe_services.filter.predictor import Predicted


class InputPath(Protocol):
    """Part of a filter node from a plant state to the message of an input, with or without prediction."""

    @property
    def horizon_ns(self) -> int:
        """Plant time of the last prediction minus that of the newest plant state, ns."""
        ...

    def restart(self) -> None:
        """Discard all state: the plant was restarted."""
        ...

    def void(self) -> None:
        """Discard what was sent: an emergency stop or its clear voids it at the plant."""
        ...

    def confirm(self, state: PlantState, known: StateSet | None = None) -> None:
        """Receive the newest plant state.

        Args:
            state: The state.
            known: Set in which the plant then is, where the scenario's sets count.
        """
        ...

    def inputs_between(self, before: PlantState, state: PlantState) -> Sequence[Vector] | None:
        """Return the input of every period from one plant state to a later one; ``None`` if they are not known."""
        ...

    def next_input(self, state: PlantState, target_ns: int) -> tuple[int, bool]:
        """Return the plant time of the next input, and whether a new sequence begins with it.

        Args:
            state: The newest plant state.
            target_ns: Plant time of the input that the schedule asks for. If the next input lies beyond it, none is
                due in this step.
        """
        ...

    def predict(self, effective_ns: int) -> Predicted:
        """Return the plant at the effective time of an input."""
        ...

    def message(self, tick: int, u: tuple[float, ...], effective_ns: int, stops_cleared: int) -> PlantInput:
        """Return the message of the input decided for the last prediction.

        Args:
            tick: Tick of the decision.
            u: The input.
            effective_ns: Plant time at which it takes effect, ns.
            stops_cleared: Number of cleared stops of the newest plant state.
        """
        ...
