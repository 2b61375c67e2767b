"""Clock of the plant, as far as the filter knows it: bounds the age of what the plant sent."""

from passafe_protocol.messages import UNKNOWN_CLOCK, PlantPhase, PlantState, Received


class PlantClock:
    """Bounds from below when the plant sent a message, on the filter's clock.

    A plant that reads the filter's clock sent it at ``scheduled_ns``. Otherwise its ``input_transit_ns`` says how far
    its plant time is ahead of the filter's clock, at the most: an input took some time to arrive.
    """

    def __init__(self, clock_id: int, epoch: int) -> None:
        """Start before the first state.

        Args:
            clock_id: The filter's clock.
            epoch: Session of the filter; transit times of others' inputs are ignored.
        """
        self._clock_id = clock_id
        self._filter_epoch = epoch
        self.restart()

    def restart(self) -> None:
        """Discard what is known."""
        self._plant_epoch = 0
        self._ahead_ns: int | None = None

    def observe(self, received: Received, state: PlantState) -> None:
        """Learn from the newest state.

        Args:
            received: Its message.
            state: Its body.
        """
        header = received.header
        if header.epoch != self._plant_epoch:
            self._plant_epoch, self._ahead_ns = header.epoch, None
        if self._clock_id != UNKNOWN_CLOCK and header.clock_id == self._clock_id:
            self._ahead_ns = 0
        elif state.phase is not PlantPhase.WAITING and state.input_epoch == self._filter_epoch:
            self._ahead_ns = header.scheduled_ns - state.plant_ns + state.input_transit_ns

    def sent_after_ns(self, epoch: int, scheduled_ns: int) -> int | None:
        """Return a time before which the plant did not send a message, filter's clock, ns; ``None`` if unknown.

        Args:
            epoch: Session of the plant.
            scheduled_ns: ``scheduled_ns`` of the message.
        """
        if self._ahead_ns is None or epoch != self._plant_epoch:
            return None
        return scheduled_ns - self._ahead_ns
