"""Transit time of inputs, which the filter's play-out schedule follows."""

from typing import Final

from passafe_protocol.messages import Received

STALL_NS: Final = 100_000_000
"""Time between two steps of the plant from which on its process counts as suspended, ns."""

SETTLE_NS: Final = 50_000_000
"""Time after a suspension in which arrivals are those of messages that waited for this process, ns."""

SPAN_NS: Final = 1_000_000_000
"""Length of one span; the maximum covers the current and the previous span."""


class TransitTime:
    """Maximum over the last 1 to 2 s of the plant time of an arrival minus the sender's clock at its step.

    The two clocks are unrelated: only the filter that owns the second clock uses the difference.

    Inputs that waited while the plant's process was suspended say nothing about the network: counted, they would have
    the filter plan ahead by the length of the suspension, and the robot would stand for as long once more.

    Attributes:
        epoch: Session of the filter; 0 before the first input.
        term: Its term (``Received.term``).
        largest_ns: The largest difference, ns.
    """

    def __init__(self) -> None:
        self.epoch = 0
        self.term = 0
        self.largest_ns = 0
        self._now_ns = self._before_ns = 0
        self._ends_ns = 0
        self._settled_ns: int | None = None

    def settle(self, resumed_ns: int) -> None:
        """Ignore arrivals of the same session for ``SETTLE_NS``: the process was suspended.

        Args:
            resumed_ns: Plant time at which it goes on, ns.
        """
        self._settled_ns = resumed_ns + SETTLE_NS

    def is_ended(self, received: Received) -> bool:
        """Return whether a message is of a session before the current one."""
        return received.term < self.term

    def is_new(self, received: Received) -> bool:
        """Return whether a message is the first of a session after the current one."""
        return received.term > self.term or (received.header.epoch != self.epoch and received.term == self.term)

    def record(self, received: Received, arrival_ns: int, made_ns: int) -> None:
        """Record an arrival.

        Args:
            received: The message; one of a new session resets the maximum, one of an ended session is ignored.
            arrival_ns: Plant time of the arrival, ns.
            made_ns: Time at which its step was due, sender's clock, ns.
        """
        transit_ns = arrival_ns - made_ns
        if self.is_new(received):
            self.epoch, self.term = received.header.epoch, received.term
            self._before_ns = self._now_ns = self.largest_ns = transit_ns
            self._ends_ns = arrival_ns + SPAN_NS
        elif self.is_ended(received) or (self._settled_ns is not None and arrival_ns < self._settled_ns):
            return
        elif arrival_ns >= self._ends_ns:
            self._before_ns, self._now_ns = self._now_ns, transit_ns
            self._ends_ns = arrival_ns + SPAN_NS
            self.largest_ns = max(self._before_ns, transit_ns)
        elif transit_ns > self._now_ns:
            self._now_ns = transit_ns
            self.largest_ns = max(self._before_ns, transit_ns)
