"""Plant node: the robot under the filter's input sequences."""

from collections.abc import Sequence

from passafe_protocol.messages import UNSEQUENCED, PlantInput, Received
from passafe_protocol.topics import CLEAR, EVENT, INPUT, STOP, Topic

from passafe.limits import Limits
from passafe_services.node import Outgoing
from passafe_services.plant.driven_robot import WAITING, DrivenRobot
from passafe_services.plant.input_check import InputCheck
from passafe_services.plant.sequenced_inputs import REFUSED, SequencedInputs
from passafe_services.plant.transit_time import STALL_NS


class PlantNode:
    """Moves the robot, one period per step, under the input sequences of a predicting filter.

    The first input takes effect one play-out time after its arrival, which defines plant time; every other one takes
    effect at its own plant time, or not at all (``passafe_services.plant.sequenced_inputs``). When one is missing, the
    fail-safe rule applies until a sequence begins that was predicted from this break. Unsequenced inputs are refused: a
    filter without prediction has its own plant node (``passafe_services.plant.unpredicted_node``).

    After skipped steps there is one state for every period that passed: the robot does not wait.
    """

    name = "plant"
    subscribes: tuple[Topic, ...] = (STOP, CLEAR, INPUT)

    def __init__(self, robot: DrivenRobot, limits: Limits) -> None:
        """Begin before the first input.

        Args:
            robot: The robot, at rest.
            limits: Limits of magnitude and norm; inputs beyond them are refused. Rates are not checked.
        """
        self._robot, self._account, self._latch = robot, robot.account, robot.latch
        self._period_ns = robot.period_ns
        self._check = InputCheck(limits)
        self._inputs = SequencedInputs(self._period_ns, self._check.is_applicable)
        self._stepped_ns = 0

    @property
    def plant_ns(self) -> int:
        """Plant time, ns."""
        return self._robot.plant_ns

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the states of every period since the previous step, or the current one; see ``Node.step``."""
        events: list[Outgoing] = []
        is_moving = self._robot.phase is not WAITING
        if is_moving and now_ns - self._stepped_ns >= STALL_NS:
            self._account.transit.settle(self._robot.plant_time_of(now_ns))
        self._stepped_ns = now_ns
        for received in inbox:
            if type(received.body) is PlantInput:
                self._receive(received, received.body)
            else:
                events += self._receive_stop(received)
        states = self._robot.run_to(now_ns, self._choose_input)
        return [*events, *states] if events else states

    def _receive_stop(self, received: Received) -> Sequence[Outgoing]:
        """Receive a press of the emergency stop or a clear; either voids all inputs."""
        event = self._latch.receive(received)
        if event is None:
            return ()
        self._inputs.void(self._robot.plant_ns)
        self._account.sequence_break_ns = self._inputs.sequence_break_ns
        return ((EVENT, event),)

    def _receive(self, received: Received, plant_input: PlantInput) -> None:
        robot, account = self._robot, self._account
        header, received_ns = received.header, received.received_ns
        if (
            not self._latch.admits(plant_input)
            or account.transit.is_ended(received)
            or plant_input.input_sequence_start_ns == UNSEQUENCED
            or not self._check.is_valid(header, plant_input)
        ):
            account.refused += 1
            return
        if account.transit.is_new(received):  # another filter, whose ticks start at 1
            account.received_tick = robot.applied_tick = 0
        oldest = self._inputs.receive(received.term, plant_input)
        if oldest is REFUSED:
            account.refused += 1
        if robot.phase is WAITING:
            if oldest is REFUSED:
                return
            robot.begin_at(self._inputs.first_ns, received_ns)
        elif plant_input.effective_plant_ns <= robot.plant_ns:
            account.late += 1
        periods = self._inputs.periods_late(received.term, plant_input) if oldest is REFUSED else max(oldest, 0)
        made_ns = header.scheduled_ns - periods * self._period_ns
        account.record_arrival(received, plant_input, robot.plant_time_of(received_ns), made_ns)

    def _choose_input(self) -> None:
        """Apply the input that is due; without one, apply the fail-safe rule and report the break of the sequence."""
        robot = self._robot
        due = self._inputs.pop_due(robot.plant_ns)
        if robot.is_blind:
            self._inputs.void(robot.plant_ns)
            self._account.sequence_break_ns = self._inputs.sequence_break_ns
            robot.apply_law()
            return
        if due is not None:
            robot.apply(due.u, due.tick, due.hold_ns, robot.plant_ns)
            return
        self._account.sequence_break_ns = self._inputs.sequence_break_ns
        robot.apply_fail_safe()
