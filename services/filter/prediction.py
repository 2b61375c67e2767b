"""The state that the plant will have when the next input takes effect."""

from collections import deque

from msgspec import Struct

from passafe.sampled_plant import Sample, SampledPlant
from passafe.tank import Tank
from protocol.messages import PlantPhase, PlantState, Vector

_WAITING = PlantPhase.WAITING

TANK_TOLERANCE_J = 1e-9
"""By how much a confirmed tank level may differ from the predicted one and still count as the same."""


class Predicted(Struct, gc=False):
    """The plant at one plant time, predicted.

    Attributes:
        plant_ns: Plant time.
        sample: The plant then.
        tank_j: Energy in the tank then.
        u: Input in force from then on, as far as it is known: the one before until another is sent.
    """

    plant_ns: int
    sample: Sample
    tank_j: float
    u: Vector


class Predictor:
    """Rolls the model forward from the newest plant state through every input sent and not yet in that state.

    A plant that does what the model says confirms the prediction to the last bit; then nothing is rolled again and
    a tick costs one step of the model, however long the delay. Otherwise the roll starts afresh from the new state.
    """

    def __init__(self, plant: SampledPlant, tank: Tank, period_ns: int) -> None:
        self._plant = plant
        self._tank = tank
        self._period_ns = period_ns
        self._path: deque[Predicted] = deque()
        self._sent: dict[int, Vector] = {}
        self._confirmed: PlantState | None = None
        self._tank_j = tank.initial_j

    @property
    def confirmed(self) -> PlantState | None:
        """The newest plant state taken in."""
        return self._confirmed

    @property
    def horizon_ns(self) -> int:
        """How far the prediction reaches beyond the newest plant state, ns."""
        return 0 if self._confirmed is None else self._path[-1].plant_ns - self._confirmed.plant_ns

    def confirm(self, state: PlantState) -> None:
        """Take a plant state in; one older than the newest changes nothing."""
        before = self._confirmed
        if before is not None:
            if state.plant_ns < before.plant_ns:
                return
            energy_in_j = state.energy_in_j - before.energy_in_j
            stored_change_j = state.energy_stored_j - before.energy_stored_j
            self._tank_j = self._tank.balance(self._tank_j, energy_in_j, stored_change_j)
        self._confirmed = state
        path, plant_ns = self._path, state.plant_ns
        while path and path[0].plant_ns < plant_ns:
            self._sent.pop(path.popleft().plant_ns, None)
        u = state.u
        if state.phase is _WAITING:
            u = self._sent.get(plant_ns, u)
        foreseen = path[0] if path else None
        if (
            foreseen is None
            or foreseen.plant_ns != plant_ns
            or foreseen.sample.x != state.x
            or foreseen.u != u
            or abs(foreseen.tank_j - self._tank_j) > TANK_TOLERANCE_J
        ):
            self._start_from(state, u)

    def sent(self, effective_plant_ns: int, u: Vector) -> None:
        """Note an input that was sent to take effect at a plant time not before the prediction's end."""
        self._sent[effective_plant_ns] = u
        path = self._path
        if path and path[-1].plant_ns == effective_plant_ns:
            path[-1].u = u

    def at(self, plant_ns: int) -> Predicted:
        """Return the plant at a time not before the newest state, as inputs sent so far will have made it.

        Before ``sent`` is called for that time, the prediction's ``u`` is the input in force until then.

        Args:
            plant_ns: Plant time, a whole number of periods after the newest state's.
        """
        last = self._path[-1]
        while last.plant_ns < plant_ns:
            before = last.sample
            sample = self._plant.advance(before.x, last.u)
            tank_j = self._tank.balance(last.tank_j, sample.energy_in_j, sample.stored_j - before.stored_j)
            time_ns = last.plant_ns + self._period_ns
            last = Predicted(time_ns, sample, tank_j, self._sent.get(time_ns, last.u))
            self._path.append(last)
        return last

    def _start_from(self, state: PlantState, u: Vector) -> None:
        self._path.clear()
        for time_ns in [time_ns for time_ns in self._sent if time_ns < state.plant_ns]:
            del self._sent[time_ns]
        sample = Sample(state.x, state.y, state.energy_stored_j, 0.0, state.integration_error)
        self._path.append(Predicted(state.plant_ns, sample, self._tank_j, u))
