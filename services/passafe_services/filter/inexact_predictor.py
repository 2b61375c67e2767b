"""Predicts the state of a plant that is not exactly its model, at a bounded cost per tick."""

from collections import deque
from typing import Final

from msgspec import Struct
from msgspec.structs import replace
from passafe_protocol.messages import PlantPhase, PlantState, Vector

from passafe.sampled_plant import SampledPlant
from passafe.state_set import ErrorGrowth, StateSet
from passafe.tank import Tank
from passafe_services.filter.predictor import Predicted, as_reported, initial_tank_j
from passafe_services.plant_contract.fail_safe import FailSafe

WAITING: Final = PlantPhase.WAITING
RUNNING: Final = PlantPhase.RUNNING

MOST_AT_ONCE: Final = 64
"""Periods by which a newer course is led on in one tick: 0.2 ms at 3 µs a period, its error set included."""

MOST_LOST: Final = 256
"""Periods without a state over which the inputs are looked up."""


class ExpectedInput(Struct, frozen=True, gc=False):
    """Input and phase that a course expects of the plant at one time.

    Attributes:
        plant_ns: Plant time, ns.
        u: Input sent for it.
        phase: Origin of the input.
        sequence_break_ns: Plant time of the last sequence break, ns.
    """

    plant_ns: int
    u: Vector
    phase: PlantPhase
    sequence_break_ns: int


class InputCourse:
    """InputCourse of the model from a plant state on, through the inputs sent.

    Attributes:
        last: Its end.
        is_undecided: Whether the input from its end on is still to be decided.
    """

    def __init__(self, begin: Predicted, held_u: Vector, *, is_undecided: bool = False) -> None:
        """Begin at a state.

        Args:
            begin: The state.
            held_u: Input that the plant holds if none follows: what a guard was asked, not what it made of it.
            is_undecided: Whether the input from the state on is still to be decided.
        """
        self.last = begin
        self.is_undecided = is_undecided
        self._held_u = held_u

    def decide_input(self, sent: Vector | None, fail_safe: FailSafe, *, may_begin: bool) -> None:
        """Decide the input from the end on, as the plant will.

        Args:
            sent: Input sent for this time; ``None`` without one.
            fail_safe: The plant's rule for missing inputs.
            may_begin: Whether a sequence begins at this time.
        """
        last, now_ns = self.last, self.last.plant_ns
        if sent is not None and (last.phase is RUNNING or may_begin):
            last.u, last.phase, last.input_since_ns = sent, RUNNING, now_ns
        else:
            if last.phase is RUNNING:
                last.sequence_break_ns = now_ns
            last.phase, last.u = fail_safe.without_input(self._held_u, last.input_since_ns, now_ns, last.sample.x)
        self._held_u = last.u
        self.is_undecided = False

    def put(self, u: Vector) -> None:
        """Put an input in force from the end on that has just been sent."""
        last = self.last
        last.u, last.phase, last.input_since_ns = u, RUNNING, last.plant_ns
        self._held_u, self.is_undecided = u, False


class InexactPredictor:
    """Integrates the model from a recent plant state through every input sent but not yet applied in that state.

    A plant that is not its model contradicts every prediction a little, and to start anew from each state would cost
    the whole delay in every tick. So a newer course is led on beside the one in use, a bounded number of periods per
    tick, and takes its place when it has caught up: at once where the delay is short, some ticks later else. Both
    rest on true states and on the same inputs; the older one's errors have only grown longer.

    Where the plant reports another sequence of inputs than was expected, the course in use is void, and the next one
    is led on at once.
    """

    def __init__(
        self,
        plant: SampledPlant,
        fail_safe: FailSafe,
        tank: Tank,
        period_ns: int,
        growth: ErrorGrowth | None = None,
    ) -> None:
        """Start with nothing received.

        Args:
            plant: Model of the plant.
            fail_safe: The plant's rule for missing inputs.
            tank: Energy tank.
            period_ns: Period of the plant, ns.
            growth: Growth of errors by the scenario's sets, where these count.
        """
        self._growth = growth
        self._plant, self._fail_safe, self._tank, self._period_ns = plant, fail_safe, tank, period_ns
        self._sent: dict[int, Vector] = {}
        self._first_ns = 0
        self._confirmed: PlantState | None = None
        self._known: StateSet | None = None
        self._tank_j = 0.0
        self._front: InputCourse | None = None
        self._newer: InputCourse | None = None
        self._expected: deque[ExpectedInput] = deque()

    @property
    def horizon_ns(self) -> int:
        """Prediction horizon: plant time of the last prediction minus that of the newest plant state, ns."""
        state, front = self._confirmed, self._front
        return 0 if state is None or front is None else front.last.plant_ns - state.plant_ns

    def restart(self) -> None:
        """Discard all state: the plant was restarted."""
        self._sent.clear()
        self._expected.clear()
        self._confirmed = self._front = self._newer = None

    def confirm(self, state: PlantState, known: StateSet | None = None) -> None:
        """Begin a newer course at a plant state; a state older than the newest is ignored.

        Args:
            state: The state.
            known: Set in which the plant then is; the course begins in its middle.
        """
        before = self._confirmed
        if before is not None and state.plant_ns < before.plant_ns:
            return
        if before is None:
            self._tank_j = initial_tank_j(self._tank, state)
        else:
            energy_in_j = state.energy_in_j - before.energy_in_j
            self._tank_j = self._tank.balance(self._tank_j, energy_in_j, state.energy_stored_j - before.energy_stored_j)
        self._confirmed, self._known = state, known
        if state.phase is WAITING and self._front is not None:
            return  # it rests until the first input takes effect
        if self._front is None or not self._is_expected(state):
            self._start_from(state)
        elif self._newer is None:
            self._newer = self._course_from(state)
        self._forget(state)

    def begin_sequence(self, first_ns: int) -> None:
        """Begin a new input sequence at a plant time; inputs sent before are void."""
        self._sent.clear()
        self._first_ns = first_ns
        state = self._confirmed
        if state is None:
            return
        self._start_from(state)
        if state.phase is WAITING and self._front is not None:  # the first input sets plant time
            begin = replace(self._front.last, plant_ns=first_ns, input_since_ns=first_ns)
            self._front = InputCourse(begin, begin.u, is_undecided=True)

    def record_sent(self, effective_plant_ns: int, u: Vector) -> None:
        """Record an input sent for the time of the last prediction."""
        self._sent[effective_plant_ns] = u
        front = self._front
        if front is not None and front.last.plant_ns == effective_plant_ns:
            front.put(u)
            self._expect(front.last)

    def predict(self, plant_ns: int) -> Predicted:
        """Return the predicted plant at a plant time.

        Args:
            plant_ns: Plant time, a whole number of periods after that of the newest state, ns.

        Raises:
            RuntimeError: No state was received.
        """
        newer = self._newer
        if newer is not None:
            if newer.last.plant_ns + MOST_AT_ONCE * self._period_ns >= plant_ns:
                self._lead(newer, plant_ns)
                self._front, self._newer = newer, None
            else:
                self._lead(newer, newer.last.plant_ns + MOST_AT_ONCE * self._period_ns)
        front = self._front
        if front is None:
            raise RuntimeError("predict: got no plant state, allowed only after confirm")
        self._lead(front, plant_ns)
        return front.last

    def inputs_between(self, before: PlantState, state: PlantState) -> list[Vector] | None:
        """Return the input of every period from one plant state to a later one; ``None`` if they are not known.

        What was sent took effect where no state between is there to tell, if the sequence goes on and no guard acted.
        """
        periods, rest = divmod(state.plant_ns - before.plant_ns, self._period_ns)
        if rest or not 0 <= periods <= MOST_LOST or before.phase is WAITING:
            return None
        if periods <= 1:
            return [before.u] * periods
        is_unbroken = before.phase is RUNNING is state.phase and state.sequence_break_ns == before.sequence_break_ns
        if not is_unbroken or state.guarded != before.guarded:
            return None
        times = range(before.plant_ns + self._period_ns, state.plant_ns, self._period_ns)
        sent = [self._sent[time_ns] for time_ns in times if time_ns in self._sent]
        return [before.u, *sent] if len(sent) == periods - 1 else None

    def _lead(self, course: InputCourse, plant_ns: int) -> None:
        """Lead a course on to a plant time; the input from there on remains undecided."""
        while course.last.plant_ns < plant_ns:
            if course.is_undecided:
                at_ns = course.last.plant_ns
                course.decide_input(self._sent.get(at_ns), self._fail_safe, may_begin=at_ns == self._first_ns)
                if course is self._front:
                    self._expect(course.last)
            last, before = course.last, course.last.sample
            sample = self._plant.advance(before.x, last.u)
            course.last = replace(
                last,
                x_error=self._grown(last),
                plant_ns=last.plant_ns + self._period_ns,
                sample=sample,
                tank_j=self._tank.balance(last.tank_j, sample.energy_in_j, sample.stored_j - before.stored_j),
            )
            course.is_undecided = True

    def _grown(self, last: Predicted) -> Vector | None:
        if self._growth is None or last.x_error is None:
            return None
        return self._growth.advance(last.sample.x, last.u, last.x_error)

    def _expect(self, last: Predicted) -> None:
        expected = self._expected
        if not expected or expected[-1].plant_ns < last.plant_ns:
            expected.append(ExpectedInput(last.plant_ns, last.u, last.phase, last.sequence_break_ns))

    def _is_expected(self, state: PlantState) -> bool:
        """Return whether the plant is in the input sequence that was expected."""
        expected = self._expected
        while expected and expected[0].plant_ns < state.plant_ns:
            expected.popleft()
        if not expected or expected[0].plant_ns != state.plant_ns:
            return False
        found, asked = expected[0], state.u_asked or state.u
        return (
            found.phase is state.phase
            and found.sequence_break_ns == state.sequence_break_ns
            and (found.phase is not RUNNING or found.u == asked)
        )

    def _forget(self, state: PlantState) -> None:
        """Forget inputs that no course will meet any more."""
        needed_ns = state.plant_ns if self._newer is None else min(state.plant_ns, self._newer.last.plant_ns)
        for time_ns in [time_ns for time_ns in self._sent if time_ns < needed_ns]:
            del self._sent[time_ns]

    def _start_from(self, state: PlantState) -> None:
        self._front, self._newer = self._course_from(state), None
        self._expected.clear()

    def _course_from(self, state: PlantState) -> InputCourse:
        begin = as_reported(state, self._tank_j)
        if self._growth is not None and self._known is not None:
            begin.sample, begin.x_error = replace(begin.sample, x=self._known.center), self._known.radius
        return InputCourse(begin, state.u_asked or state.u)
