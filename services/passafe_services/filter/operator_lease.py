"""Lease of the operator whose commands count: one session at a time, lost by silence or by an explicit take-over."""

from enum import Enum
from typing import Final

from passafe_protocol.messages import Event, OperatorCommand, OperatorLease, Received

LEASE_NS: Final = 1_000_000_000
"""Silence after which the holder loses the lease."""

REPORT_PERIOD_NS: Final = 200_000_000
"""Period of the reports; a change is reported at once."""

EVENT_PERIOD_NS: Final = 1_000_000_000
"""Least time between two events about refused commands."""

_NOBODY: Final = 0
_UNKNOWN_NS: Final = -1


class LeaseAnswer(Enum):
    """Outcome of a command at the lease."""

    HOLDS = "holds"
    """Its session holds the lease, which it renews."""

    GRANTED = "granted"
    """Its session has just received the lease."""

    REFUSED = "refused"
    """Another session holds the lease."""


_HOLDS: Final = LeaseAnswer.HOLDS


class OperatorLeases:
    """Grants the lease to one operator session at a time.

    A free lease goes to the next session of which a command comes. While it is held, other commands are refused, unless
    one asks for the lease by its number (``OperatorCommand.take_over``): such a request concerns that lease alone, so
    one that was late on its way cannot take the next lease. All times are those at which commands left their link.
    """

    def __init__(self) -> None:
        """Start with a free lease."""
        self._events: list[Event] = []
        self.restart()

    def restart(self) -> None:
        """Free the lease and begin its numbers anew."""
        self._events.clear()
        self._number = 0
        self._holder, self._device = _NOBODY, ""
        self._renewed_ns = 0
        self._refused = _NOBODY
        self._quiet_until_ns = self._report_ns = 0

    def admit(self, received: Received, command: OperatorCommand) -> LeaseAnswer:
        """Return what becomes of a command, and renew or grant the lease.

        Args:
            received: The message.
            command: Its body.
        """
        epoch, now_ns = received.header.epoch, received.received_ns
        if epoch == self._holder:
            self._renewed_ns = max(now_ns, self._renewed_ns)
            if command.device != self._device:  # a page took the place of the script, or the other way round
                self._device, self._report_ns = command.device, 0
            return _HOLDS
        if self._is_held(now_ns) and not 0 < command.take_over == self._number:
            self._refuse(epoch, command.device, now_ns)
            return LeaseAnswer.REFUSED
        self._grant(epoch, command.device, now_ns)
        return LeaseAnswer.GRANTED

    def pop_events(self) -> list[Event]:
        """Remove and return the events since the last call."""
        events, self._events = self._events, []
        return events

    def report(self, now_ns: int) -> OperatorLease | None:
        """Return the lease if a report is due: at once after a change, and every ``REPORT_PERIOD_NS``.

        Args:
            now_ns: Monotonic time, ns.
        """
        if now_ns < self._report_ns:
            return None
        self._report_ns = now_ns + REPORT_PERIOD_NS
        if not self._is_held(now_ns):
            return OperatorLease(self._number, _NOBODY, "", _UNKNOWN_NS, self._refused)
        age_ns = max(now_ns - self._renewed_ns, 0)
        return OperatorLease(self._number, self._holder, self._device, age_ns, self._refused)

    def _is_held(self, now_ns: int) -> bool:
        return self._holder != _NOBODY and now_ns - self._renewed_ns <= LEASE_NS

    def _grant(self, epoch: int, device: str, now_ns: int) -> None:
        if self._holder != _NOBODY:
            how = (
                f"took over from {self._words}" if self._is_held(now_ns) else f"follows {self._words}, which is silent"
            )
            self._events.append(Event("warning", f"operator session {epoch} ({device}) {how}"))
        self._number += 1
        self._holder, self._device, self._renewed_ns = epoch, device, now_ns
        self._refused, self._report_ns = _NOBODY, 0

    def _refuse(self, epoch: int, device: str, now_ns: int) -> None:
        if epoch == self._refused or now_ns < self._quiet_until_ns:
            return
        self._refused, self._report_ns, self._quiet_until_ns = epoch, 0, now_ns + EVENT_PERIOD_NS
        text = f"commands of operator session {epoch} ({device}) do not count: {self._words} holds the lease"
        self._events.append(Event("warning", text))

    @property
    def _words(self) -> str:
        return f"session {self._holder} ({self._device})"
