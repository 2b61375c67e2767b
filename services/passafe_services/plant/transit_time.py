"""How long inputs take to come: what the filter's play-out time follows."""

from typing import Final

SPAN_NS: Final = 1_000_000_000
"""Length of one span; the largest of the present and of the last one counts."""


class TransitTime:
    """The largest of the last second or two of (plant time of an arrival − sender's clock when it was made).

    The two clocks have nothing in common, and need not: only the filter whose clock it is makes use of the difference.

    Attributes:
        epoch: Session of the filter whose clock it is; 0 before the first input.
        largest_ns: The largest difference, ns.
    """

    def __init__(self) -> None:
        self.epoch = 0
        self.largest_ns = 0
        self._now_ns = self._before_ns = 0
        self._ends_ns = 0

    def note(self, epoch: int, arrival_ns: int, made_ns: int) -> None:
        """Note an arrival.

        Args:
            epoch: Session of the sender; a new one starts afresh, an old one counts for nothing.
            arrival_ns: Plant time of the arrival, ns.
            made_ns: When it was due to be made, by the sender's clock, ns.
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
