"""The state that the plant will have when the next input takes effect."""

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
    """The plant at one plant time, predicted.

    Attributes:
        plant_ns: Plant time.
        sample: The plant then.
        tank_j: Energy in the tank then.
        u: Input in force from then on, as far as it is known: the one before until another is sent.
        phase: What decides it.
        input_since_ns: Plant time from which the last input has been in force.
        sequence_break_ns: Plant time at which an input was missing last.
    """

    plant_ns: int
    sample: Sample
    tank_j: float
    u: Vector
    phase: PlantPhase
    input_since_ns: int
    sequence_break_ns: int


class Predictor:
    """Rolls the model forward from the newest plant state through every input sent and not yet in that state.

    What the plant does where an input is missing is part of the model: it holds the last one, then follows its
    fail-safe law. Since no input takes effect unless all before it did, the prediction for an input that does is
    exact, however bad the network, if the model is.

    A plant that does what the model says confirms the prediction to the last bit; then nothing is rolled again and
    a tick costs one step of the model, however long the delay. Otherwise the roll starts afresh from the new state.
    """

    def __init__(self, plant: SampledPlant, fail_safe: FailSafe, tank: Tank, period_ns: int) -> None:
        """Start with nothing heard.

        Args:
            plant: The model.
            fail_safe: The plant's rule for missing inputs.
            tank: Energy ledger.
            period_ns: Period of the plant, ns.
        """
        self._plant = plant
        self._fail_safe = fail_safe
        self._tank = tank
        self._period_ns = period_ns
        self._path: deque[Predicted] = deque()
        self._sent: dict[int, Vector] = {}
        self._first_ns = 0
        self._open = False  # whether what is in force from the end of the path on is not decided yet
        self._confirmed: PlantState | None = None
        self._tank_j = 0.0

    @property
    def horizon_ns(self) -> int:
        """How far the prediction reaches beyond the newest plant state, ns."""
        return 0 if self._confirmed is None else self._path[-1].plant_ns - self._confirmed.plant_ns

    def restart(self) -> None:
        """Forget everything: the plant is another one."""
        self._path.clear()
        self._sent.clear()
        self._confirmed = None

    def confirm(self, state: PlantState) -> None:
        """Compare the prediction with a plant state; one older than the newest changes nothing."""
        before = self._confirmed
        if before is not None and state.plant_ns < before.plant_ns:
            return
        if before is None:
            self._tank_j = opening_tank_j(self._tank, state)
        self._confirmed = state
        path, plant_ns = self._path, state.plant_ns
        if state.phase is WAITING and path:
            return  # it rests until the first input of what was sent
        while path and path[0].plant_ns < plant_ns:
            self._sent.pop(path.popleft().plant_ns, None)
        foreseen = path[0] if path else None
        if (
            foreseen is not None
            and foreseen.plant_ns == plant_ns
            and foreseen.sample.x == state.x
            and foreseen.u == state.u
            and foreseen.sequence_break_ns == state.sequence_break_ns
            and foreseen.phase is state.phase
        ):
            self._tank_j = foreseen.tank_j
            return
        if before is not None:
            energy_in_j = state.energy_in_j - before.energy_in_j
            self._tank_j = self._tank.balance(self._tank_j, energy_in_j, state.energy_stored_j - before.energy_stored_j)
        self._start_from(state)

    def begin(self, first_ns: int) -> None:
        """Note that a new input sequence begins at a plant time; inputs sent before are void."""
        self._sent.clear()
        self._first_ns = first_ns
        state = self._confirmed
        if state is not None:
            self._start_from(state)
            if state.phase is WAITING:  # the first input sets plant time
                self._path[0].plant_ns = self._path[0].input_since_ns = first_ns
                self._open = True

    def sent(self, effective_plant_ns: int, u: Vector) -> None:
        """Note an input that was sent for the time that ``at`` was asked about last."""
        self._sent[effective_plant_ns] = u
        last = self._path[-1]
        if last.plant_ns == effective_plant_ns:
            last.u, last.phase, last.input_since_ns = u, RUNNING, effective_plant_ns
            self._open = False

    def at(self, plant_ns: int) -> Predicted:
        """Return the plant at a time, and what is in force until then.

        Args:
            plant_ns: Plant time, a whole number of periods after the newest state's.
        """
        path, period_ns = self._path, self._period_ns
        last = path[-1]
        while last.plant_ns < plant_ns:
            if self._open:
                self._close(last)
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
            self._open = True
        return last

    def _close(self, last: Predicted) -> None:
        """Decide what is in force from the end of the path on, as the plant will."""
        now_ns = last.plant_ns
        u = self._sent.get(now_ns)
        if u is not None and (last.phase is RUNNING or now_ns == self._first_ns):
            last.u, last.phase, last.input_since_ns = u, RUNNING, now_ns
            return
        if last.phase is RUNNING:
            last.sequence_break_ns = now_ns
        last.phase, last.u = self._fail_safe.without_input(last.u, last.input_since_ns, now_ns, last.sample.x)

    def _start_from(self, state: PlantState) -> None:
        self._path.clear()
        for time_ns in [time_ns for time_ns in self._sent if time_ns < state.plant_ns]:
            del self._sent[time_ns]
        sample = Sample(state.x, state.y, state.energy_stored_j, 0.0, state.integration_error)
        self._path.append(
            Predicted(
                state.plant_ns,
                sample,
                self._tank_j,
                state.u,
                state.phase,
                state.input_since_ns,
                state.sequence_break_ns,
            )
        )
        self._open = False


def opening_tank_j(tank: Tank, state: PlantState) -> float:
    """Return the energy in the tank at the first state that is received, J.

    A plant that moves has been another filter's, which may have drawn the tank down: it is not filled again.
    """
    return tank.initial_j if state.phase is WAITING else tank.reserve_j
