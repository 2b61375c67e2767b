"""Send time of a command whose sender reads another clock, from its echo of a plant state."""

from passafe_protocol.messages import OperatorCommand, Received

from passafe_services.filter.plant_clock import PlantClock
from passafe_services.filter.send_time import SendTime


class CommandSendTime(SendTime):
    """Send times of commands, never too late where they echo a plant state.

    A command was sent ``echoed_for_ns`` after the state had arrived at the operator, and that after the plant had sent
    it. The age that follows includes the state's way to the operator, whatever the operator's clock: also a delay that
    all messages have, which cannot be seen from one side. An echo that the filter cannot place, such as one of an ended
    session of the plant, leaves the age of the last one in force.
    """

    def __init__(self, clock_id: int, plant: PlantClock) -> None:
        """Start with nothing received.

        Args:
            clock_id: The filter's clock.
            plant: Clock of the plant.
        """
        self._plant = plant
        super().__init__(clock_id)

    def restart(self) -> None:
        """See ``SendTime``."""
        super().restart()
        self._bound_ns: int | None = None

    def _estimate(self, received: Received) -> int:
        estimate_ns, body = super()._estimate(received), received.body
        if not isinstance(body, OperatorCommand) or not body.echoed_epoch:
            return estimate_ns
        after_ns = self._plant.sent_after_ns(body.echoed_epoch, body.echoed_ns)
        if after_ns is not None:
            self._bound_ns = max(received.received_ns - after_ns - body.echoed_for_ns, 0)
        return estimate_ns if self._bound_ns is None else received.received_ns - self._bound_ns
