"""Where the operator's clock stands, told from what arrives: for the time between two commands, not their age."""

from typing import Final

DRIFT: Final = 10_000
"""One part in this many is by how much two clocks may run apart; quartz stays below a tenth of it."""


class SenderClock:
    """Takes the fastest message of late for one without delay.

    The sender's clock is at received − (least of received − scheduled). Jitter falls out of it; the least delay itself
    cannot be seen without a common clock, and stays in. The least is forgotten at the rate at which clocks may drift.
    """

    def __init__(self) -> None:
        """Start with nothing heard."""
        self._origin_ns = 0
        self._newest_ns = 0
        self._heard_ns = 0
        self._offset_ns: int | None = None

    def restart(self) -> None:
        """Forget everything."""
        self._offset_ns = None

    def runs_on(self, scheduled_ns: int) -> bool:
        """Tell whether a newer message's time is a later one: not where a clock was set back or stands still."""
        return self._offset_ns is None or scheduled_ns > self._newest_ns

    def hear(self, scheduled_ns: int, received_ns: int) -> int:
        """Take in when a message was made and when it came.

        Args:
            scheduled_ns: Sender's clock, ns.
            received_ns: Reader's clock, ns; never smaller than before.

        Returns:
            By how much longer than the fastest it was on its way, ns.
        """
        offset_ns = received_ns - scheduled_ns
        if self._offset_ns is None:
            self._origin_ns = self._newest_ns = scheduled_ns
            self._offset_ns = offset_ns
        else:
            drifted_ns = self._offset_ns + max(received_ns - self._heard_ns, 0) // DRIFT
            self._offset_ns = min(drifted_ns, offset_ns)
            self._newest_ns = max(self._newest_ns, scheduled_ns)
        self._heard_ns = received_ns
        return offset_ns - self._offset_ns

    def sent_s(self, scheduled_ns: int) -> float:
        """Return a time of the sender's clock, s since the first message."""
        return (scheduled_ns - self._origin_ns) * 1e-9

    def now_s(self, now_ns: int) -> float:
        """Return what ``sent_s`` would say of a message that arrives at ``now_ns`` without delay."""
        return (now_ns - (self._offset_ns or 0) - self._origin_ns) * 1e-9
