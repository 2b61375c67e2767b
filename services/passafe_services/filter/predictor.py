"""Predicts the plant state at the effective time of the next input."""

from collections import deque
from typing import Final

from msgspec import Struct
from passafe_protocol.messages import PlantPhase, PlantState, Vector

from passafe.sampled_plant import Sample, SampledPlant
from passafe.tank import Tank
from passafe_services.plant_contract.fail_safe import FailSafe

WAITING: Final = PlantPhase.WAITING
RUNNING: Final = PlantPhase.RUNNING


class Predicted(Struct, gc=False):
    """Predicted plant at one plant time.

    Attributes:
        plant_ns: Plant time, ns.
        sample: State, output and energies.
        tank_j: Energy in the tank, J.
        u: Input in force from then on; the previous one until another is sent.
        phase: Origin of the input.
        input_since_ns: Plant time at which the last input took effect, ns.
        sequence_break_ns: Plant time of the last sequence break, ns.
        x_error: Largest error of the state for every member of the scenario's sets; ``None`` where they do not count.
    """

    plant_ns: int
    sample: Sample
    tank_j: float
    u: Vector
    phase: PlantPhase
    input_since_ns: int
    sequence_break_ns: int
    x_error: Vector | None = None


class Predictor:
    """Integrates the model from the newest plant state through every input sent but not yet applied in that state.

    The response of the plant to a missing input is part of the model: it holds the last input, then follows its
    fail-safe law. Since an input takes effect only if all previous ones of its sequence did, the prediction for an
    applied input is exact for any network, provided that the model is.

    A plant that follows the model confirms the prediction to the last bit; then a tick costs one step of the model,
    whatever the delay. Otherwise the prediction is recomputed from the new state.
    """

    def __init__(self, plant: SampledPlant, fail_safe: FailSafe, tank: Tank, period_ns: int) -> None:
        """Start with nothing received.

        Args:
            plant: Model of the plant.
            fail_safe: The plant's rule for missing inputs.
            tank: Energy tank.
            period_ns: Period of the plant, ns.
        """
        self._plant = plant
        self._fail_safe = fail_safe
        self._tank = tank
        self._period_ns = period_ns
        self._trajectory: deque[Predicted] = deque()
        self._sent: dict[int, Vector] = {}
        self._first_ns = 0
        self._undecided = False  # whether the input from the end of the trajectory on is still to be decided
        self._confirmed: PlantState | None = None
        self._tank_j = 0.0

    @property
    def horizon_ns(self) -> int:
        """Prediction horizon: plant time of the last prediction minus that of the newest plant state, ns."""
        return 0 if self._confirmed is None else self._trajectory[-1].plant_ns - self._confirmed.plant_ns

    def restart(self) -> None:
        """Discard all state: the plant was restarted."""
        self._trajectory.clear()
        self._sent.clear()
        self._confirmed = None

    def confirm(self, state: PlantState) -> None:
        """Compare the prediction with a plant state; a state older than the newest is ignored."""
        before = self._confirmed
        if before is not None and state.plant_ns < before.plant_ns:
            return
        if before is None:
            self._tank_j = initial_tank_j(self._tank, state)
        self._confirmed = state
        path, plant_ns = self._trajectory, state.plant_ns
        if state.phase is WAITING and path:
            return  # it rests until the first input takes effect
        while path and path[0].plant_ns < plant_ns:
            self._sent.pop(path.popleft().plant_ns, None)
        predicted = path[0] if path else None
        if (
            predicted is not None
            and predicted.plant_ns == plant_ns
            and predicted.sample.x == state.x
            and predicted.u == state.u
            and predicted.sequence_break_ns == state.sequence_break_ns
            and predicted.phase is state.phase
        ):
            self._tank_j = predicted.tank_j
            return
        if before is not None:
            energy_in_j = state.energy_in_j - before.energy_in_j
            self._tank_j = self._tank.balance(self._tank_j, energy_in_j, state.energy_stored_j - before.energy_stored_j)
        self._start_from(state)

    def begin_sequence(self, first_ns: int) -> None:
        """Begin a new input sequence at a plant time; inputs sent before are void."""
        self._sent.clear()
        self._first_ns = first_ns
        state = self._confirmed
        if state is not None:
            self._start_from(state)
            if state.phase is WAITING:  # the first input sets plant time
                self._trajectory[0].plant_ns = self._trajectory[0].input_since_ns = first_ns
                self._undecided = True

    def record_sent(self, effective_plant_ns: int, u: Vector) -> None:
        """Record an input sent for the time of the last prediction."""
        self._sent[effective_plant_ns] = u
        last = self._trajectory[-1]
        if last.plant_ns == effective_plant_ns:
            last.u, last.phase, last.input_since_ns = u, RUNNING, effective_plant_ns
            self._undecided = False

    def predict(self, plant_ns: int) -> Predicted:
        """Return the predicted plant at a plant time.

        Args:
            plant_ns: Plant time, a whole number of periods after that of the newest state, ns.
        """
        path, period_ns = self._trajectory, self._period_ns
        last = path[-1]
        while last.plant_ns < plant_ns:
            if self._undecided:
                self._decide_input(last)
            before = last.sample
            sample = self._plant.advance(before.x, last.u)
            tank_j = self._tank.balance(last.tank_j, sample.energy_in_j, sample.stored_j - before.stored_j)
            last = Predicted(
                last.plant_ns + period_ns,
                sample,
                tank_j,
                last.u,
                last.phase,
                last.input_since_ns,
                last.sequence_break_ns,
            )
            path.append(last)
            self._undecided = True
        return last

    def _decide_input(self, last: Predicted) -> None:
        """Decide the input from the end of the trajectory on, as the plant will."""
        now_ns = last.plant_ns
        u = self._sent.get(now_ns)
        if u is not None and (last.phase is RUNNING or now_ns == self._first_ns):
            last.u, last.phase, last.input_since_ns = u, RUNNING, now_ns
            return
        if last.phase is RUNNING:
            last.sequence_break_ns = now_ns
        last.phase, last.u = self._fail_safe.without_input(last.u, last.input_since_ns, now_ns, last.sample.x)

    def _start_from(self, state: PlantState) -> None:
        self._trajectory.clear()
        for time_ns in [time_ns for time_ns in self._sent if time_ns < state.plant_ns]:
            del self._sent[time_ns]
        self._trajectory.append(as_reported(state, self._tank_j))
        self._undecided = False


def as_reported(state: PlantState, tank_j: float) -> Predicted:
    """Return the plant as a state reports it.

    Args:
        state: The state.
        tank_j: Energy in the tank then, J.
    """
    return Predicted(
        state.plant_ns,
        Sample(state.x, state.y, state.energy_stored_j, 0.0, state.integration_error),
        tank_j,
        state.u,
        state.phase,
        state.input_since_ns,
        state.sequence_break_ns,
    )


def initial_tank_j(tank: Tank, state: PlantState) -> float:
    """Return the energy in the tank at the first state received, J.

    A moving plant was driven by another filter, which may have drained the tank: it is not refilled.
    """
    return tank.initial_j if state.phase is WAITING else tank.reserve_j
