"""State for the decisions of a filter without prediction: the newest plant state, whatever its age."""

from passafe_protocol.messages import UNSEQUENCED, PlantState, Vector

from passafe.sampled_plant import Sample
from passafe.tank import Tank
from passafe_services.filter.predictor import Predicted, initial_tank_j


class UnpredictedState:
    """Keeps the newest plant state, its tank energy and the input sent last."""

    def __init__(self, tank: Tank) -> None:
        """Start with nothing received.

        Args:
            tank: Energy tank.
        """
        self._tank = tank
        self.restart()

    def restart(self) -> None:
        """Discard all state: the plant was restarted."""
        self._confirmed: PlantState | None = None
        self._tank_j = 0.0
        self._u: Vector | None = None

    def void(self) -> None:
        """Forget the input sent last: the plant did not apply it."""
        self._u = None

    def confirm(self, state: PlantState) -> None:
        """Keep a plant state; a state older than the newest is ignored."""
        before = self._confirmed
        if before is None:
            self._tank_j = initial_tank_j(self._tank, state)
        else:
            if state.plant_ns < before.plant_ns:
                return
            energy_in_j = state.energy_in_j - before.energy_in_j
            stored_j = state.energy_stored_j - before.energy_stored_j
            self._tank_j = self._tank.balance(self._tank_j, energy_in_j, stored_j)
        self._confirmed = state

    def at(self, plant_ns: int) -> Predicted:
        """Return the newest state, whatever the time, with the input sent last.

        Raises:
            RuntimeError: No state was received.
        """
        state = self._confirmed
        if state is None:
            raise RuntimeError("at: got no plant state, allowed only after confirm")
        sample = Sample(state.x, state.y, state.energy_stored_j, 0.0, state.integration_error)
        u = state.u if self._u is None else self._u
        return Predicted(plant_ns, sample, self._tank_j, u, state.phase, state.input_since_ns, UNSEQUENCED)

    def record_sent(self, u: Vector) -> None:
        """Record the input sent last."""
        self._u = u
