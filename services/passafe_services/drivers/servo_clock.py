"""Times of a servo's measurements on the clock of the plant node."""

from typing import Final

DRIFT: Final = 100e-6
"""Difference of the rates of both clocks that is allowed for: ten times that of ordinary crystals."""


class ServoClock:
    """Relates the servo's clock to ours by the shortest time that an answer was on its way.

    No answer arrives before it was measured, so that arrival − servo's clock is never below the true difference, and
    near it for the quickest answer. As both clocks drift apart, the least difference is let grow with time. So a
    measurement is taken for older than it is by no more than drift, and for younger by no more than the way of the
    quickest answer.
    """

    def __init__(self) -> None:
        """Start before the first answer."""
        self._least_ns: float | None = None
        self._since_ns = 0

    def time_of(self, servo_ns: int, arrival_ns: int) -> int:
        """Return when a measurement was made, our clock, ns.

        Args:
            servo_ns: The servo's clock when it measured, ns.
            arrival_ns: When its answer arrived, our clock, ns.
        """
        difference = float(arrival_ns - servo_ns)
        if self._least_ns is None:
            self._least_ns = difference
        else:
            self._least_ns = min(difference, self._least_ns + DRIFT * (arrival_ns - self._since_ns))
        self._since_ns = arrival_ns
        return servo_ns + round(self._least_ns)
