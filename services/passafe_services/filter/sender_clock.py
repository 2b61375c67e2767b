"""Estimates a sender's clock from message arrivals, up to the least delay, which cannot be seen from one side."""

from typing import Final

DRIFT: Final = 10_000
"""Inverse of the largest relative drift between two clocks; quartz stays below a tenth of 1/``DRIFT``."""


class SenderClock:
    """Estimates the clock offset as that of the fastest recent message.

    The sender's clock reads received − min(received − scheduled). Jitter cancels; the minimum delay itself cannot be
    observed without a common clock and remains. The minimum is relaxed at the largest drift rate of the clocks.
    """

    def __init__(self) -> None:
        """Start with nothing received."""
        self._origin_ns = 0
        self._newest_ns = 0
        self._received_ns = 0
        self._offset_ns: int | None = None

    def restart(self) -> None:
        """Discard the estimate."""
        self._offset_ns = None

    def advances(self, scheduled_ns: int) -> bool:
        """Check whether the time of a newer message is later: not if its clock was set back or stands still."""
        return self._offset_ns is None or scheduled_ns > self._newest_ns

    def update(self, scheduled_ns: int, received_ns: int) -> int:
        """Update the estimate with a message.

        Args:
            scheduled_ns: Time of the message by the sender's clock, ns.
            received_ns: Time of arrival by the reader's clock, ns; non-decreasing.

        Returns:
            Delay of the message beyond that of the fastest one, ns.
        """
        offset_ns = received_ns - scheduled_ns
        if self._offset_ns is None:
            self._origin_ns = self._newest_ns = scheduled_ns
            self._offset_ns = offset_ns
        else:
            drifted_ns = self._offset_ns + max(received_ns - self._received_ns, 0) // DRIFT
            self._offset_ns = min(drifted_ns, offset_ns)
            self._newest_ns = max(self._newest_ns, scheduled_ns)
        self._received_ns = received_ns
        return offset_ns - self._offset_ns

    def sent_s(self, scheduled_ns: int) -> float:
        """Return a time of the sender's clock in s since the first message."""
        return (scheduled_ns - self._origin_ns) * 1e-9

    def now_s(self, now_ns: int) -> float:
        """Return ``sent_s`` of a message without excess delay that arrives at ``now_ns``."""
        return (now_ns - (self._offset_ns or 0) - self._origin_ns) * 1e-9
