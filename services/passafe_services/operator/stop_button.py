"""Emergency stop at the operator: its button, and the dead-man switch that it releases."""

from msgspec.structs import replace
from passafe_protocol.messages import EmergencyStop, PlantState
from passafe_protocol.stop_request import StopRequest, press_id

from passafe_services.operator.sources.command import Command


class StopButton:
    """Button that presses the emergency stop, and the rule for commands while one is latched.

    While the newest plant state shows a stop, the command is a released zero. After the clear a script goes on; a
    person has to let go of the device once, so that nothing that was held through the stop moves the robot.

    Attributes:
        source: Process that pressed the stop that is latched; empty: none is.
    """

    def __init__(self, epoch: int) -> None:
        """Start without a press.

        Args:
            epoch: Session of the operator.
        """
        self._epoch = epoch
        self._presses = 0
        self._request: StopRequest | None = None
        self._must_release = False
        self.source = ""

    def press(self) -> None:
        """Press it."""
        self._presses += 1
        self._request = StopRequest(EmergencyStop(press_id(self._epoch, self._presses), "pressed by the operator"))

    def observe(self, state: PlantState) -> None:
        """Learn from a newer plant state.

        Args:
            state: The newest state.
        """
        self.source = (state.stop_source or "an unnamed process") if state.stop else ""
        if self._request is not None:
            self._request.observe(state)
        if state.stop:
            self._must_release = True

    def due(self, now_ns: int) -> EmergencyStop | None:
        """Return the press if it is to be sent now: it is repeated until a plant state names it.

        Args:
            now_ns: Monotonic time, ns.
        """
        body = None if self._request is None else self._request.due(now_ns)
        return body if isinstance(body, EmergencyStop) else None

    def limit(self, command: Command, *, is_person: bool) -> Command:
        """Return the command as it may be sent: a released zero while it must not act.

        Args:
            command: Command of the source.
            is_person: Whether a person gave it.
        """
        if not self.source and self._must_release and (not is_person or not command.enabled):
            self._must_release = False
        if not self._must_release:
            return command
        zero = (0.0,) * len(command.u_h)
        return replace(command, u_h=zero, u_h_rate=zero if command.u_h_rate else (), enabled=False)
