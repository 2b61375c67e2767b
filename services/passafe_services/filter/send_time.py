"""Send time of a message on the receiver's clock, from which its age counts."""

from passafe_protocol.messages import UNKNOWN_CLOCK, Received

from passafe_services.filter.sender_clock import SenderClock


class SendTime:
    """Estimates the send times of one topic's messages, each newer than the one before.

    Where sender and receiver read the same monotonic clock (``clock_id``), the send time is that of the header.
    Otherwise it is the arrival less the delay beyond that of the fastest recent message (``SenderClock``): the least
    delay cannot be observed from one direction, so the estimate is late by it, never early by more than the clocks'
    drift. A new session, and a clock that was set back, begin a new estimate. A message from the future shows that its
    sender's clock is not the one that it names.
    """

    def __init__(self, clock_id: int) -> None:
        """Start with nothing received.

        Args:
            clock_id: The receiver's clock.
        """
        self._clock_id = clock_id
        self._clock = SenderClock()
        self.restart()

    def restart(self) -> None:
        """Discard the estimate."""
        self._clock.restart()
        self._epoch = -1
        self._is_trusted = self._clock_id != UNKNOWN_CLOCK
        self._scheduled_ns = 0
        self._received_ns = 0

    def of(self, received: Received) -> int:
        """Return the time at which a message was sent, receiver's monotonic clock, ns; never after its arrival.

        Args:
            received: The message, the newest so far.
        """
        header, received_ns = received.header, received.received_ns
        if header.epoch != self._epoch:
            self.restart()
            self._epoch = header.epoch
        if self._is_trusted and header.clock_id == self._clock_id:
            if header.scheduled_ns <= received_ns:
                return header.scheduled_ns
            self._is_trusted = False
        return self._estimate(received)

    def _estimate(self, received: Received) -> int:
        """Return the send time of a message whose sender reads another clock."""
        header, received_ns = received.header, received.received_ns
        if not self._is_plausible(header.scheduled_ns, received_ns):
            self._clock.restart()
        self._scheduled_ns, self._received_ns = header.scheduled_ns, received_ns
        return received_ns - self._clock.update(header.scheduled_ns, received_ns)

    def _is_plausible(self, scheduled_ns: int, received_ns: int) -> bool:
        """Check that the sender's clock advances; a plant that catches up sends several states at one time."""
        return self._clock.advances(scheduled_ns) or (scheduled_ns, received_ns) == (
            self._scheduled_ns,
            self._received_ns,
        )
