"""Transit time of inputs, which the filter's play-out schedule follows."""

from typing import Final

SPAN_NS: Final = 1_000_000_000
"""Length of one span; the maximum covers the current and the previous span."""


class TransitTime:
    """Maximum over the last 1 to 2 s of the plant time of an arrival minus the sender's clock at its step.

    The two clocks are unrelated: only the filter that owns the second clock uses the difference.

    Attributes:
        epoch: Session of the filter; 0 before the first input.
        largest_ns: The largest difference, ns.
    """

    def __init__(self) -> None:
        self.epoch = 0
        self.largest_ns = 0
        self._now_ns = self._before_ns = 0
        self._ends_ns = 0

    def record(self, epoch: int, arrival_ns: int, made_ns: int) -> None:
        """Record an arrival.

        Args:
            epoch: Session of the sender; a new session resets the maximum, an ended one is ignored.
            arrival_ns: Plant time of the arrival, ns.
            made_ns: Time at which its step was due, sender's clock, ns.
        """
        transit_ns = arrival_ns - made_ns
        if epoch > self.epoch:
            self.epoch = epoch
            self._before_ns = self._now_ns = self.largest_ns = transit_ns
            self._ends_ns = arrival_ns + SPAN_NS
        elif epoch < self.epoch:
            return
        elif arrival_ns >= self._ends_ns:
            self._before_ns, self._now_ns = self._now_ns, transit_ns
            self._ends_ns = arrival_ns + SPAN_NS
            self.largest_ns = max(self._before_ns, transit_ns)
        elif transit_ns > self._now_ns:
            self._now_ns = transit_ns
            self.largest_ns = max(self._before_ns, transit_ns)
