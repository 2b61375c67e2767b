"""The plant process as a node: the simulated robot, its play-out buffer and its own fail-safe."""

from collections.abc import Sequence
from math import hypot, inf
from typing import Final

from passafe_protocol.messages import UNSEQUENCED, Event, Header, PlantInput, PlantPhase, PlantState, Received, Vector
from passafe_protocol.topics import EVENT, INPUT, STATE, Topic

from passafe.limits import Limits
from passafe.sampled_plant import SampledPlant
from passafe_services.node import Outgoing
from passafe_services.plant.playout_buffer import PlayoutBuffer
from passafe_services.plant.sequenced_inputs import REFUSED, SequencedInputs
from passafe_services.plant.transit_time import TransitTime
from passafe_services.plant_contract.fail_safe import FailSafe

ROUNDING: Final = 1e-12
"""By how much an input shortened to its norm's limit may still be longer, relative."""

FAR_NS: Final = 2**61
"""73 years: no clock shows more."""

# Members by name: reaching one through its enumeration takes 0.7 µs on Python 3.11.
WAITING: Final = PlantPhase.WAITING
RUNNING: Final = PlantPhase.RUNNING
HOLDING: Final = PlantPhase.HOLDING
FAIL_SAFE: Final = PlantPhase.FAIL_SAFE


class PlantNode:
    """Integrates the robot, one period a step, under the inputs of the filter.

    Until the first input arrives the robot rests at x0 (``WAITING``). That input takes effect ``playout`` later
    than it arrived, which sets plant time; every other takes effect at the plant time it names, or not at all:
    inputs come in sequences (``passafe_services.plant.sequenced_inputs``). When one is missing, the last is held for
    as long as it may be in force (``HOLDING``), then the model's own law takes over (``FAIL_SAFE``), until an arming
    begins that was made for this. Inputs of no arming are of a filter that does not predict: they are applied when
    they are due, or late.

    A driver that skipped steps gets one state for every period that passed: time does not stop for a robot.

    Attributes:
        name: ``plant``.
        subscribes: Inputs of the filter.
        plant_ns: Plant time, ns.
    """

    name = "plant"
    subscribes: tuple[Topic, ...] = (INPUT,)

    def __init__(
        self,
        plant: SampledPlant,
        fail_safe: FailSafe,
        *,
        x0: Sequence[float],
        period_ns: int,
        playout_ns: int,
        limits: Limits,
    ) -> None:
        """Put the robot at rest at x0.

        Args:
            plant: The model, stepped with the period.
            fail_safe: What is in force where no input follows.
            x0: Initial state, n numbers.
            period_ns: Period of a step, ns.
            playout_ns: How long before its effect the first input should have arrived, ns.
            limits: Inputs beyond their magnitudes or their norm are refused; how fast u changes is not looked at.
        """
        m = plant.system.m
        self._plant = plant
        self._fail_safe = fail_safe
        self._sample = plant.at(x0)
        self._period_ns = period_ns
        self._playout_ns = playout_ns
        self._m, self._bounds, self._least_bound = m, limits.magnitude, min(limits.magnitude)
        self._norm = inf if limits.norm is None else limits.norm * (1 + ROUNDING)
        self._armed = SequencedInputs(period_ns, self._is_applicable)
        self._loose = PlayoutBuffer(period_ns)
        self._has_loose = False
        self._transit = TransitTime()
        self._origin_ns = 0
        self._has_origin = False
        self.plant_ns = 0
        self._u: Vector = (0.0,) * m
        self._applied_tick = 0
        self._received_tick = 0
        self._since_ns = 0
        self._hold_ns = 0
        self._phase = WAITING
        self._energy_in_j = 0.0
        self._slack_ns = 0
        self._late = 0
        self._refused = 0

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the state now, and those of every period that passed since the step before.

        Args:
            now_ns: Monotonic time of this step, ns.
            inbox: Inputs, in order of arrival.
        """
        for received in inbox:
            if type(received.body) is PlantInput:
                self._receive(received.header, received.body, received.received_ns)
        if not self._has_origin or now_ns < self._origin_ns + self.plant_ns:
            return ((STATE, self._state()),)
        outgoing: list[Outgoing] = []
        if self._phase is WAITING:
            outgoing += self._choose_input()
            outgoing.append((STATE, self._state()))
            if self._phase is WAITING:  # the first input was none after all
                self._has_origin = False
                return outgoing
        while self._origin_ns + self.plant_ns + self._period_ns <= now_ns:
            self._sample = self._plant.advance(self._sample.x, self._u)
            self._energy_in_j += self._sample.energy_in_j
            self.plant_ns += self._period_ns
            outgoing += self._choose_input()
            outgoing.append((STATE, self._state()))
        return outgoing or ((STATE, self._state()),)

    def _receive(self, header: Header, plant_input: PlantInput, received_ns: int) -> None:
        foreign = header.epoch < self._transit.epoch
        if foreign or not self._is_applicable(plant_input.u) or not self._is_plausible(header, plant_input):
            self._refused += 1
            return
        if header.epoch > self._transit.epoch:  # another filter: its ticks begin anew
            self._received_tick = self._applied_tick = 0
        due_ns = plant_input.effective_plant_ns
        if plant_input.input_sequence_start_ns == UNSEQUENCED:
            admission = self._put_loose(plant_input)
        else:
            admission = self._armed.put(header, plant_input)
        if admission is REFUSED:
            self._refused += 1
        if self._phase is WAITING:
            if admission is REFUSED:
                return
            self._set_plant_time(plant_input, received_ns)
        elif due_ns <= self.plant_ns:
            self._late += 1
        arrival_ns = received_ns - self._origin_ns
        back = self._armed.missed(header, plant_input) if admission is REFUSED else max(admission, 0)
        self._transit.note(header.epoch, arrival_ns, header.scheduled_ns - back * self._period_ns)
        if plant_input.tick >= self._received_tick:
            self._received_tick = plant_input.tick
            self._slack_ns = due_ns - arrival_ns

    def _put_loose(self, plant_input: PlantInput) -> int:
        """Keep an input of no arming until it is due; while one of an arming is in force, none is wanted."""
        if self._armed.armed or not self._loose.put(plant_input):
            return REFUSED
        self._has_loose = True
        return 0

    def _set_plant_time(self, plant_input: PlantInput, received_ns: int) -> None:
        """Let the first input take effect one play-out time after it came, unless that is settled already."""
        first_ns = self._armed.first_ns
        if first_ns == UNSEQUENCED:
            first_ns = self.plant_ns if self._has_origin else plant_input.effective_plant_ns
        if not self._has_origin or first_ns != self.plant_ns:
            self.plant_ns, self._has_origin = first_ns, True
            # Steps come on a grid: the first one after the buffer has filled is plant time `first_ns`.
            self._origin_ns = received_ns + self._playout_ns - first_ns

    def _is_plausible(self, header: Header, plant_input: PlantInput) -> bool:
        """Tell whether the numbers beside u could be a filter's; what the plant says of them has to fit a message."""
        repeated, rest = divmod(len(plant_input.previous_u), self._m)
        is_timely = 0 <= plant_input.effective_plant_ns <= FAR_NS and -FAR_NS <= header.scheduled_ns <= FAR_NS
        return is_timely and not rest and repeated <= plant_input.tick

    def _is_applicable(self, u: Vector) -> bool:
        """Tell whether an input has the plant's shape and lies within the limits; a NaN does not."""
        if len(u) != self._m:
            return False
        least = self._least_bound
        for value in u:
            if not -least <= value <= least:
                return all(-bound <= value <= bound for value, bound in zip(u, self._bounds, strict=True)) and (
                    hypot(*u) <= self._norm
                )
        return self._norm == inf or hypot(*u) <= self._norm

    def _choose_input(self) -> Sequence[Outgoing]:
        """Decide what is in force from the present plant time on; return an event when that changes in kind."""
        before = self._phase
        due = self._armed.take(self.plant_ns)
        if due is not None:
            self._u, self._applied_tick, self._hold_ns = due.u, due.tick, due.hold_ns
            self._since_ns, self._phase = self.plant_ns, RUNNING
        elif not (self._has_loose and self._take_loose()) and before is not WAITING:
            self._phase, self._u = self._fail_safe.without_input(
                self._u, self._since_ns, self.plant_ns, self._sample.x, self._hold_ns
            )
        return () if self._phase is before else self._announce(before)

    def _take_loose(self) -> bool:
        """Put an input of no arming in force, if a newer one than before is due."""
        due = self._loose.take(self.plant_ns)
        if due is None or due.tick <= self._applied_tick:
            return False
        if self._phase is not RUNNING:  # a filter that predicts has to know of this before its inputs count
            self._armed.break_off(self.plant_ns)
        self._u, self._applied_tick, self._hold_ns = due.u, due.tick, due.hold_ns
        self._since_ns, self._phase = due.effective_plant_ns, RUNNING
        return True

    def _announce(self, before: PlantPhase) -> list[Outgoing]:
        if before is not FAIL_SAFE and self._phase is not FAIL_SAFE:
            return []
        at = f"plant time {self.plant_ns / 1e9:.3f} s"
        if self._phase is FAIL_SAFE:
            return [(EVENT, Event("warning", f"inputs stopped: fail-safe law in force at {at}"))]
        return [(EVENT, Event("info", f"inputs are back: fail-safe law released at {at}"))]

    def _state(self) -> PlantState:
        sample, transit = self._sample, self._transit
        return PlantState(
            self.plant_ns,
            sample.x,
            sample.y,
            self._u,
            self._applied_tick,
            self._phase,
            self._energy_in_j,
            sample.stored_j,
            self._slack_ns,
            self._late,
            self._refused,
            sample.integration_error,
            self._received_tick,
            self._armed.sequence_break_ns,
            self._since_ns,
            transit.largest_ns,
            transit.epoch,
        )
