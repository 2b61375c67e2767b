"""The newest plant state, as old as it is: what a filter without prediction decides for."""

from passafe_protocol.messages import UNSEQUENCED, PlantState, Vector

from passafe.sampled_plant import Sample
from passafe.tank import Tank
from passafe_services.filter.predictor import Predicted, opening_tank_j


class UnpredictedState:
    """Keeps the newest plant state, the energy in the tank then, and the input that was sent last."""

    def __init__(self, tank: Tank) -> None:
        """Start with nothing received.

        Args:
            tank: Energy ledger.
        """
        self._tank = tank
        self.restart()

    def restart(self) -> None:
        """Forget everything: the plant is another one."""
        self._confirmed: PlantState | None = None
        self._tank_j = 0.0
        self._u: Vector | None = None

    def confirm(self, state: PlantState) -> None:
        """Keep a plant state; one older than the newest changes nothing."""
        before = self._confirmed
        if before is None:
            self._tank_j = opening_tank_j(self._tank, state)
        else:
            if state.plant_ns < before.plant_ns:
                return
            energy_in_j = state.energy_in_j - before.energy_in_j
            stored_j = state.energy_stored_j - before.energy_stored_j
            self._tank_j = self._tank.balance(self._tank_j, energy_in_j, stored_j)
        self._confirmed = state

    def at(self, plant_ns: int) -> Predicted:
        """Return the newest state, whatever the time, and the input that was sent last.

        Raises:
            RuntimeError: No state was received.
        """
        state = self._confirmed
        if state is None:
            raise RuntimeError("at: got no plant state, allowed only after confirm")
        sample = Sample(state.x, state.y, state.energy_stored_j, 0.0, state.integration_error)
        u = state.u if self._u is None else self._u
        return Predicted(plant_ns, sample, self._tank_j, u, state.phase, state.input_since_ns, UNSEQUENCED)

    def sent(self, u: Vector) -> None:
        """Note the input that was sent last."""
        self._u = u
