"""Plant node for a filter without prediction: applies inputs when they are due, or late."""

from collections.abc import Sequence

from passafe_protocol.messages import UNSEQUENCED, PlantInput, Received
from passafe_protocol.topics import CLEAR, EVENT, INPUT, STOP, Topic

from passafe.limits import Limits
from passafe_services.node import Outgoing
from passafe_services.plant.driven_robot import RUNNING, WAITING, DrivenRobot
from passafe_services.plant.input_check import InputCheck
from passafe_services.plant.playout_buffer import MOST_PENDING, PlayoutBuffer


class UnpredictedPlantNode:
    """Moves the robot, one period per step, under the unsequenced inputs of a filter without prediction.

    ``filter.prediction = false`` shows the effect of delay: an input takes effect at its plant time, or on arrival if
    that is later, whatever the state of the plant. Sequenced inputs are refused.
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
        self._inputs = PlayoutBuffer(self._period_ns)

    @property
    def plant_ns(self) -> int:
        """Plant time, ns."""
        return self._robot.plant_ns

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the states of every period since the previous step, or the current one; see ``Node.step``."""
        events: list[Outgoing] = []
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
        return ((EVENT, event),)

    def _receive(self, received: Received, plant_input: PlantInput) -> None:
        robot, account = self._robot, self._account
        header, received_ns = received.header, received.received_ns
        if (
            not self._latch.admits(plant_input)
            or account.transit.is_ended(received)
            or plant_input.input_sequence_start_ns != UNSEQUENCED
            or not self._check.is_valid(header, plant_input)
            or self._is_far_ahead(plant_input)
            or not self._inputs.put(plant_input)
        ):
            account.refused += 1
            return
        if account.transit.is_new(received):  # another filter, whose ticks start at 1
            account.received_tick = robot.applied_tick = 0
        if robot.phase is WAITING:
            if not robot.has_origin:
                robot.begin_at(plant_input.effective_plant_ns, received_ns)
        elif plant_input.effective_plant_ns <= robot.plant_ns:
            account.late += 1
        account.record_arrival(received, plant_input, robot.plant_time_of(received_ns), header.scheduled_ns)

    def _is_far_ahead(self, plant_input: PlantInput) -> bool:
        """Check whether an input is due so late that a few thousand like it would keep the buffer full for good."""
        ahead_ns = plant_input.effective_plant_ns - self._robot.plant_ns
        return self._robot.has_origin and ahead_ns > MOST_PENDING * self._period_ns

    def _choose_input(self) -> None:
        """Apply the newest input that is due, unless a newer one is in force."""
        robot = self._robot
        due = self._inputs.pop_due(robot.plant_ns)
        if robot.is_blind:
            self._inputs.void(robot.plant_ns)
            robot.apply_law()
            return
        if due is None or due.tick <= robot.applied_tick:
            robot.apply_fail_safe()
            return
        if robot.phase is not RUNNING:
            self._account.sequence_break_ns = robot.plant_ns
        robot.apply(due.u, due.tick, due.hold_ns, due.effective_plant_ns)
